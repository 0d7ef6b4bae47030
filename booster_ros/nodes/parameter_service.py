# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services that set parameters: all of one request or none, and equal values are no change."""

from collections.abc import Callable, Sequence

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.exceptions import ParameterNotDeclaredException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService

Converted = Callable[[Parameter], Parameter]


class AllOrNone(ParameterService):
    """
    Serves a node made without these services; what it gives and describes is as of any node.

    rclpy sets the parameters of one request one by one: a file loaded into a running node left a
    mixture where one of its values was refused. Here that refuses all of them. What is equal to
    the value in force is no change, and not refused where it is read-only.
    """

    def __init__(self, node: Node, converted: Converted) -> None:
        """Offer the services; `converted` returns a parameter as it is declared."""
        self._own_node = node
        self._converted = converted
        super().__init__(node)

    def _set_parameters_callback(
        self, request: SetParameters.Request, response: SetParameters.Response
    ) -> SetParameters.Response:
        changes = self._changes(request.parameters)
        result = self._set_together(changes)
        same = SetParametersResult(successful=True)
        changed = {parameter.name for parameter in changes}
        response.results = [
            result if message.name in changed else same for message in request.parameters]
        return response

    def _set_parameters_atomically_callback(
        self, request: SetParametersAtomically.Request,
        response: SetParametersAtomically.Response,
    ) -> SetParametersAtomically.Response:
        response.result = self._set_together(self._changes(request.parameters))
        return response

    def _changes(self, messages: Sequence[ParameterMessage]) -> list[Parameter]:
        """Return the parameters of a request whose values are not in force."""
        given = {message.name: Parameter.from_parameter_msg(message) for message in messages}
        return [parameter for parameter in given.values() if not self._is_in_force(parameter)]

    def _is_in_force(self, parameter: Parameter) -> bool:
        if not self._own_node.has_parameter(parameter.name):
            return False
        now = self._own_node.get_parameter(parameter.name)
        new = self._converted(parameter)
        return new.type_ == now.type_ and _plain(new) == _plain(now)

    def _set_together(self, changes: list[Parameter]) -> SetParametersResult:
        if not changes:
            return SetParametersResult(successful=True)
        try:
            result = self._own_node.set_parameters_atomically(changes)
        except ParameterNotDeclaredException as error:
            return SetParametersResult(successful=False, reason=str(error))
        if not result.successful and len(changes) > 1:
            result.reason += f' (none of {len(changes)} changed parameters has been set)'
        return result


def _plain(parameter: Parameter) -> object:
    value = parameter.value
    return list(value) if hasattr(value, '__len__') and not isinstance(value, str) else value
