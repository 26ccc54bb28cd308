"""The machine that moves a robot, in `improv.toml`."""

from __future__ import annotations

from improv_core.score.score import DeviceAddress, Host
from tests.robots.drawing import check


def test_a_robot_is_moved_by_the_stage_of_its_host() -> None:
    found = check("""
        [robots.anna]
        host = "pi@anna.local"
        link_patience = 3
        [robots.bob]
        host = "bob"
        [robots.carla]
        [hosts."pi@anna.local"]
        domain = 7
        rmw = "rmw_fastrtps_cpp"
    """)
    hosts = {name: robot.host for name, robot in found.robots.items()}
    assert hosts == {"anna": Host("pi@anna.local", 7, "rmw_fastrtps_cpp", 3.0), "bob": Host("bob"), "carla": None}


def test_the_patience_of_a_link_needs_a_host() -> None:
    check("""
        [robots.bob]
        link_patience = 3
        ^^^^^^^^^^^^^ robots: `link_patience` is about a robot with a `host`: add it
    """)


def test_names_unsafe_for_ssh_or_a_shell_are_no_hosts() -> None:
    """tests/safety/test_allowed.py has these names."""
    plain = "use a name as in ~/.ssh/config, `user@machine`, or `user@machine:port`: letters, digits, `_`, `.`, and `-`"
    found = check(f"""
        [robots.anna]
        host = "-oProxyCommand=id"
               ^^^^^^^^^^^^^^^^^^^ robots: {plain}
        [hosts."a b"]
               ^^^^^ robots: `a b` can't be a host: {plain}
        [robots.bob]
        host = "x\\n"
               ^^^^^ robots: {plain}
    """)
    assert (found.robots["anna"].host, found.robots["bob"].host) == (None, None)


def test_an_output_moves_a_robot_at_its_address() -> None:
    found = check("""
        [robots.ada]
        output = "thymio"
        address = "serial:/dev/ttyACM0"
        node = 1
        [robots.bob]
        output = "thymio"
        address = "serial:/dev/ttyACM0"
        node = 2
    """)
    places = [(robot.host, robot.device) for robot in found.robots.values()]
    assert places == [(Host("thymio", output=True), DeviceAddress("serial:/dev/ttyACM0", node)) for node in (1, 2)]
    assert not found.lacks("ada", "near")


def test_errors_in_outputs_are_reported() -> None:
    needs = "an `output` needs an `address`, such as `serial:/dev/ttyACM0` or `tcp:localhost:33333`"
    install = "install its package with `pip`"
    twice = "`dora` is the robot at this address, too: give each its own `address` or `node`"
    check(f"""
        [robots.ada]
        output = "thimyo"
                 ^^^^^^^^ robots: no output `thimyo` is installed: did you mean `thymio`? If not, {install}
        address = "tcp:localhost:33333"
        [robots.bob]
        output = "thymio"
        ^^^^^^ robots: {needs}
        [robots.carla]
        output = "thymio"
        address = "localhost:33333"
                  ^^^^^^^^^^^^^^^^^ robots: {needs}
        [robots.dora]
        output = "thymio"
        address = "tcp:localhost:33334"
        host = "dora"
        ^^^^ robots: `output` moves this robot from here: remove one of the two
        topic = "dora/cmd_vel"
        ^^^^^ robots: `output` moves this robot without ROS 2: remove `topic`
        [robots.emil]
        output = "thymio"
        address = "tcp:localhost:33334"
                  ^^^^^^^^^^^^^^^^^^^^^ robots: {twice}
        [robots.fred]
        node = 3
        ^^^^ robots: `node` is about a robot with an `output`: add it
        [robots.gina]
        output = "sphero"
                 ^^^^^^^^ robots: no output `sphero` is installed: {install}
        address = "tcp:localhost:33336"
        [robots.hans]
        output = "ros"
                 ^^^^^ robots: ROS 2 and the simulator need no `output`: remove it
        address = "tcp:localhost:33337"
    """)


def test_an_output_and_a_host_with_one_name_are_told_apart() -> None:
    check("""
        [robots.ada]
        host = "thymio"
        [robots.bob]
        output = "thymio"
                 ^^^^^^^^ robots: `thymio` is also a host: give that another name in ~/.ssh/config
        address = "tcp:localhost:33335"
    """)
