"""A client of Improv's node, run by ROS's interpreter: each line of input is a request, each line of output an answer.

`call NAME` calls a service (std_srvs/Trigger), `get NODE PARAMETER` and `set NODE PARAMETER NUMBER` are for parameters,
and `nodes` lists them.
"""

import json
import sys

import own_output  # noqa: F401, before any library may print
import rclpy
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from std_srvs.srv import Trigger

LIMIT = 60.0
LOST = 5.0
"""Seconds after which to send a request again: DDS loses an answer to a client that the server hasn't found yet."""

rclpy.init()
node = rclpy.create_node("asker")
clients = {}


def ask(kind, service, request):
    if service not in clients:
        clients[service] = node.create_client(kind, service)
    assert clients[service].wait_for_service(LIMIT), service
    for _ in range(int(LIMIT / LOST)):
        answer = clients[service].call_async(request)
        rclpy.spin_until_future_complete(node, answer, timeout_sec=LOST)
        if answer.done():
            break
    return answer.result()


def call(service):
    answer = ask(Trigger, service, Trigger.Request())
    return [answer.success, answer.message]


def get(name, parameter):
    answer = ask(GetParameters, f"{name}/get_parameters", GetParameters.Request(names=[parameter]))
    return answer.values[0].double_value


def change(name, parameter, number):
    value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=float(number))
    request = SetParameters.Request(parameters=[Parameter(name=parameter, value=value)])
    answer = ask(SetParameters, f"{name}/set_parameters", request).results[0]
    return [answer.successful, answer.reason]


commands = {"call": call, "get": get, "set": change}
print(flush=True)
for line in sys.stdin:
    command, *words = line.split()
    print(json.dumps(commands[command](*words)), flush=True)
node.destroy_node()
rclpy.try_shutdown()
