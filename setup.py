# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0

from glob import glob

from setuptools import find_packages, setup

package_name = 'booster_ros'

setup(
    name=package_name,
    version='0.1.0',
    packages=find_packages(exclude=['test', 'test.*']),
    package_data={package_name: ['py.typed', 'paper/data/*.csv', 'report/templates/*.html',
                                 'report/plotly/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
        ('share/' + package_name, ['package.xml']),
        ('share/' + package_name + '/launch', glob('launch/*.launch.py')),
        ('share/' + package_name + '/config', glob('config/*')),
        ('share/' + package_name + '/urdf', glob('urdf/*')),
        # what `ros2 param describe` and the configuration point to
        ('share/' + package_name + '/docs', glob('docs/*.md')),
        ('share/' + package_name + '/docs/images', glob('docs/images/*')),
        ('share/' + package_name + '/examples', glob('examples/*.*')),
    ],
    install_requires=['setuptools'],
    # By this colcon knows that the tests are pytest's.
    extras_require={
        'test': ['pytest'],
        # read and written by rosbags, which is in no distribution's packages
        'bags': ['rosbags'],
        # files of others: units, workbooks, MATLAB 7.3, Parquet and Feather
        'files': ['h5py', 'openpyxl', 'pandas', 'pint', 'pyarrow'],
        # many valves side by side, and their table as Parquet
        'fleet': ['distributed', 'pyarrow'],
    },
    python_requires='>=3.10',
    zip_safe=False,
    maintainer='The booster_ros authors',
    maintainer_email='maintainers@example.org',
    description='A simulated electro-pneumatic valve positioner, and a program that says what a '
    'model of a real one lacks.',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'positioner = booster_ros.__main__:positioner',
            'fake_controller = booster_ros.__main__:fake_controller',
            'twin = booster_ros.__main__:twin',
            'simulate = booster_ros.__main__:simulate',
            'inspect = booster_ros.__main__:inspect',
            'close_loop = booster_ros.__main__:close_loop',
            'fleet = booster_ros.__main__:fleet',
            'metrics = booster_ros.__main__:metrics',
            'paper = booster_ros.__main__:paper',
            'demo = booster_ros.__main__:demo',
            'campaign = booster_ros.__main__:campaign',
        ],
    },
)
