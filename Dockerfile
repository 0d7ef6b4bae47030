# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
#
# The package on ROS 2 Jazzy, with what is read from bags and the model compiled beforehand:
#   docker build -t booster_ros .
#   docker run --rm -it booster_ros ros2 run booster_ros positioner
# Written after the images' own pages; not built where it was written.
FROM ros:jazzy-ros-base

RUN apt-get update && apt-get install --yes --no-install-recommends \
        python3-matplotlib python3-numba python3-numpy python3-pip python3-scipy python3-tqdm \
        python3-yaml \
    && rm -rf /var/lib/apt/lists/* \
    && pip install --break-system-packages --no-cache-dir rosbags

WORKDIR /workspace
COPY . src/booster_ros
RUN . /opt/ros/jazzy/setup.sh && colcon build --packages-select booster_ros

# compiled for the processor that builds the image; on another one it is compiled once more
ENV XDG_CACHE_HOME=/var/cache/programs
RUN mkdir -m 700 "$XDG_CACHE_HOME" && . install/setup.sh \
    && printf 'time,control_current\n0,0.0004\n1,0.0004\n' > /tmp/in.csv \
    && ros2 run booster_ros simulate --input /tmp/in.csv --out /tmp/out.csv \
        --params install/booster_ros/share/booster_ros/config/positioner.yaml \
    && rm /tmp/in.csv /tmp/out.csv

RUN printf '#!/bin/bash\nset -e\n. /workspace/install/setup.bash\nexec "$@"\n' > /entry.sh \
    && chmod +x /entry.sh
ENTRYPOINT ["/entry.sh"]
CMD ["ros2", "run", "booster_ros", "positioner"]
