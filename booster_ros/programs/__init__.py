# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The programs: arguments in, files and sentences out.

They put whole simulations side by side on the cores. Threads of the linear algebra beneath them
would wait for each other on those cores, so it gets one thread, unless the user set another
number. That number is read when numpy is first imported, and this package is imported before.

They draw into files. The variable that chooses a window for matplotlib's figures would do nothing,
but keep matplotlib from being imported where it names what is not there.
"""

import os

for _library in ('OPENBLAS', 'OMP', 'MKL'):
    os.environ.setdefault(f'{_library}_NUM_THREADS', '1')

os.environ.pop('MPLBACKEND', None)
