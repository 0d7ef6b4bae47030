# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A node that is refused its parameters leaves nothing behind in the process that wanted it."""

from __future__ import annotations

from positioner_here import context_here
import pytest
import rclpy

from booster_ros.model.parameters import ParameterError
from booster_ros.nodes.fake_controller import FakeController
from booster_ros.nodes.positioner import Positioner
from booster_ros.nodes.twin import TwinNode


@pytest.mark.parametrize(('make', 'parameter'), [
    (Positioner, 'supply.pressure'), (TwinNode, 'rate'), (FakeController, 'rate')])
def test_others_do_not_see_it(make, parameter):
    with context_here('-p', f'{parameter}:=-1.0') as arguments:
        with pytest.raises(ParameterError, match=parameter) as refused:
            make(arguments)
        other = rclpy.create_node('other')
        assert other.get_node_names() == ['other']
        other.destroy_node()
    assert refused.tb  # what was on the way to it is still there: nothing was cleared up by luck
