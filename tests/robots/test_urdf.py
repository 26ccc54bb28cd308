"""URDFs: their joints, the reasons for which some are refused, and the sections of `improv.toml` made from them."""

from __future__ import annotations

import contextlib
import io
import math
from operator import attrgetter

import pytest
from urdf_parser_py.urdf import URDF

from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots
from improv_core.robots.urdf import LARGEST_URDF, UrdfError, read_urdf
from improv_core.robots.urdf_sections import sections
from improv_core.slices import on_checkpoint


def revolute(name: str, parent: str, child: str, axis: str, place: str, more: str = "") -> str:
    """Write a joint that turns from -90° to 120°, and a quarter turn a second at most."""
    return f"""
      <joint name="{name}" type="revolute">
        <parent link="{parent}"/><child link="{child}"/>
        <axis xyz="{axis}"/><origin xyz="{place}"/>
        <limit lower="{-math.pi / 2}" upper="{math.pi * 2 / 3}" velocity="{math.pi / 2}" effort="1"/>{more}
      </joint>"""


def arm(side: str, y: str) -> str:
    """Write two joints and a fixed hand: the arm points forward."""
    return (
        f'<link name="{side}_upper"/><link name="{side}_fore"/><link name="{side}_hand"/>'
        + revolute(f"{side}_shoulder", "torso", f"{side}_upper", "0 1 0", f"0 {y} 1")
        + revolute(f"{side}_elbow", f"{side}_upper", f"{side}_fore", "0 0 1", "0.3 0 0")
        + f'<joint name="{side}_wrist" type="fixed"><parent link="{side}_fore"/><child link="{side}_hand"/>'
        + '<origin xyz="0.3 0 0"/></joint>'
    )


def robot(*inside: str) -> str:
    return f'<robot name="doll">{"".join(inside)}</robot>'


DOLL = robot(
    '<link name="base"/><link name="torso"/>',
    revolute("waist", "base", "torso", "0 0 -1", "0 0 0.5"),
    arm("left", "0.2"),
    arm("right", "-0.2"),
)

ARMS = """\
# From doll.urdf. Check to which side each direction moves its joint, and how far in a beat.
# Joints behind # have no direction yet: give them forward, strafeleft, up, or left, or a part of their own
# (improv body --part NAME=LINK).
[profiles.doll]
step = 0.2 # meters that its base drives in a beat: write yours
joint_states = "joint_states"

[profiles.doll.body.left_fore] # what moves left_fore
mirror = "right_fore"
up = { joint = "left_shoulder", degrees = -30 }
left = { joint = "left_elbow", degrees = 30 }

[profiles.doll.body.right_fore] # what moves right_fore
up = { joint = "right_shoulder", degrees = -30 }
left = { joint = "right_elbow", degrees = 30 }
"""


def test_each_chain_that_ends_in_a_leaf_is_a_part_and_left_mirrors_right() -> None:
    made = sections(read_urdf(DOLL.encode()), "doll.urdf")
    assert made.startswith(ARMS)
    assert made.endswith("# In no part:\n# waist: it carries torso; --part NAME=torso makes it a part\n")


def test_proposed_sections_can_be_used_as_they_are() -> None:
    toml = sections(read_urdf(DOLL.encode()), "doll.urdf", tips={"arm": "left_hand", "whole": "right_hand"})
    robots = read_robots(f'{toml}\n[robots.ada]\nprofile = "doll"\n')
    assert robots.diagnostics == ()
    assert "# left_elbow: choose a direction\n" in toml  # `left` is the waist's
    assert "# [profiles.doll.joints.left_elbow]\n# min = -90\n" in toml
    assert analyze("ada $ arm (up left) || whole (up up)", robots).diagnostics == ()


def test_a_named_part_ends_at_its_link_and_begins_after_the_one_nearest_to_the_root() -> None:
    made = sections(read_urdf(DOLL.encode()), "doll.urdf", "nao", {"right_arm": "right_hand", "chest": "torso"})
    body = [line for line in made.splitlines() if "joint =" in line or ".body." in line]
    assert body == [
        "[profiles.nao.body.right_arm] # what moves right_hand",
        'up = { joint = "right_shoulder", degrees = -30 }',
        'left = { joint = "right_elbow", degrees = 30 }',
        "[profiles.nao.body.chest] # what moves torso",
        'left = { joint = "waist", degrees = -30 }',
    ]


@pytest.mark.parametrize(
    ("kind", "axis", "turn", "tip", "direction"),
    [
        ("revolute", "0 0 1", "0 0 0", "1 0 0", "left = { joint = 'j', degrees = 30 }"),
        ("revolute", "0 0 1", f"{math.pi} 0 0", "1 0 0", "left = { joint = 'j', degrees = -30 }"),
        ("revolute", "0 1 0", "0 0 0", "1 0 0", "up = { joint = 'j', degrees = -30 }"),
        ("revolute", "0 1 0", "0 0 0", "0 0 -1", "forward = { joint = 'j', degrees = -30 }"),
        ("revolute", "1 0 0", "0 0 0", "0 0 -1", "strafeleft = { joint = 'j', degrees = 30 }"),
        ("revolute", "1 0 0", "0 0 0", "1 0 0", "# j: choose a direction"),
        ("revolute", "0 1 0", "0 0 0", "0 0 0", "up = { joint = 'j', degrees = -30 }"),
        ("prismatic", "1 0 0", f"0 {-math.pi / 2} 0", "0 0 0", "up = { joint = 'j', meters = 0.05 }"),
        ("prismatic", "0 -2 0", "0 0 0", "0 0 0", "strafeleft = { joint = 'j', meters = -0.05 }"),
        ("prismatic", "1 1 1", "0 0 0", "0 0 0", "# j: choose a direction"),
    ],
)
def test_a_direction_follows_the_motion_of_the_tip(kind: str, axis: str, turn: str, tip: str, direction: str) -> None:
    made = sections(
        read_urdf(
            robot(
                '<link name="a"/><link name="b"/><link name="c"/>',
                f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><axis xyz="{axis}"/>',
                f'<origin rpy="{turn}"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>',
                f'<joint name="k" type="fixed"><parent link="b"/><child link="c"/><origin xyz="{tip}"/></joint>',
            ).encode()
        ),
        "x.urdf",
        tips={"part": "c"},
    )
    assert direction.replace("'", '"') in made


def test_a_joint_that_follows_another_or_that_no_number_moves_is_in_no_part() -> None:
    made = sections(
        read_urdf(
            robot(
                '<link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/>',
                revolute("yaw", "a", "b", "0 0 1", "0 0 0"),
                revolute("other", "a", "c", "0 0 1", "0 0 0", '<mimic joint="yaw"/>'),
                '<joint name="flies" type="floating"><parent link="a"/><child link="d"/></joint>',
                '<joint name="wheel" type="continuous"><parent link="a"/><child link="e"/><axis xyz="0 1 0"/></joint>',
            ).encode()
        ),
        "x.urdf",
    )
    assert made.partition("# In no part:\n")[2].splitlines() == [
        "# other: it follows yaw",
        "# flies: no single number moves a floating joint",
        "# wheel: it carries e; --part NAME=e makes it a part",
    ]


def test_a_joint_that_can_t_stand_at_0_starts_in_the_middle_and_missing_limits_are_said() -> None:
    made = sections(
        read_urdf(
            robot(
                '<link name="a"/><link name="b"/><link name="c"/>',
                '<joint name="up" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>',
                '<limit lower="0.2" upper="0.6" effort="1" velocity="0"/></joint>',
                '<joint name="round" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/></joint>',
            ).encode()
        ),
        "x.urdf",
    )
    assert (
        "joints.up]\nmin = 0.2\nmax = 0.6\n# The file sets no speed limit: write a max_velocity.\nstart = 0.4 #" in made
    )
    assert made.endswith("joints.round]\n# The file sets no speed limit: write a max_velocity.\n")


def test_joints_that_transmissions_and_controllers_name_are_not_read_twice() -> None:
    more = (
        '<transmission><joint name="waist"/></transmission><ros2_control><joint name="waist"/></ros2_control></robot>'
    )
    assert read_urdf(DOLL.replace("</robot>", more).encode()) == read_urdf(DOLL.encode())


NAME = attrgetter("name")
ATTRIBUTES = " ".join(f'a{number}=""' for number in range(999))
LINKS = '<link name="a"/>\n<link name="b"/>\n'
ENDS = '<parent link="a"/><child link="b"/>'


def joint(inside: str = ENDS, head: str = 'name="j" type="revolute"') -> str:
    return f"<joint {head}>{inside}</joint>"


BACK = joint('<parent link="b"/><child link="a"/>', 'name="k" type="fixed"')
BOMB = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>\n<robot name="&b;"/>'


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", 1, "this is not XML: no element found"),
        ("hello", 1, "this is not XML: syntax error"),
        ("<robot>", 1, "this is not XML: no element found"),
        ("<sdf/>", 1, "a URDF begins with <robot>, not with <sdf>"),
        ("\n<robot><xacro:include/></robot>", 2, "this is a xacro file: run `xacro FILE > robot.urdf`, and read that"),
        (BOMB, 1, "a URDF must not declare a document type or entities: remove them"),
        ("<robot/>", 0, "the URDF has no links"),
        (robot("<link/>"), 1, "a link has no name"),
        (robot('<link name="a"/>\n<link name="a"/>'), 2, "there are two links 'a'"),
        (robot(LINKS, joint(), joint()), 3, "there are two joints 'j'"),
        (
            robot(LINKS, joint(), "\n", joint(head='name="k" type="fixed"')),
            4,
            "the joints 'j' and 'k' both carry the link 'b': only one can",
        ),
        (robot(LINKS), 2, "no joint connects the links 'a' and 'b': all links must form one tree"),
        (
            robot(LINKS, '<link name="c"/>', joint(), BACK),
            3,
            "the joint 'j' is in a loop: all links must form one tree",
        ),
    ],
)
def test_a_urdf_that_can_t_be_used_is_refused_in_one_line(text: str, line: int, message: str) -> None:
    with pytest.raises(UrdfError) as refused:
        read_urdf(text.encode())
    assert (refused.value.line, str(refused.value)) == (line, message)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (joint(head='type="fixed"'), "a joint has no name"),
        (joint(head='name="j"'), "the joint 'j' has no type"),
        (
            joint(head='name="j" type="spring"'),
            "the joint 'j' has the unknown type 'spring': "
            "write revolute, continuous, prismatic, fixed, floating, planar",
        ),
        (joint('<parent link="a"/>'), "the joint 'j' has no <child link>, or it has no link"),
        (joint('<parent link="a"/><child link="x"/>'), "the joint 'j' names the link 'x', which is not there"),
        (joint(f'{ENDS}<limit lower="2" upper="1"/>'), "the joint 'j' has its lower limit 2 above its upper limit 1"),
        (joint(f'{ENDS}<limit lower="nan" upper="1"/>'), "the joint 'j' has lower='nan': write one finite number"),
        (joint(f'{ENDS}<limit velocity="-1"/>'), "the joint 'j' has the velocity limit -1: it must not be negative"),
        (joint(f'{ENDS}<axis xyz="0 0 0"/>'), "the joint 'j' has an axis of length 0"),
        (joint(f'{ENDS}<origin xyz="1 2"/>'), "the joint 'j' has xyz='1 2': write 3 finite numbers"),
    ],
)
def test_a_joint_that_can_t_be_used_is_refused_at_its_line(wrong: str, message: str) -> None:
    with pytest.raises(UrdfError) as refused:
        read_urdf(robot(LINKS, wrong).encode())
    assert (refused.value.line, str(refused.value)) == (3, message)


@pytest.mark.parametrize(
    ("tips", "message"),
    [
        ({"arm": "nothing"}, "the file has no link 'nothing': name another tip for the part 'arm'"),
        ({"arm": "base"}, "no joint with a motor is left for the part 'arm', with the tip 'base'"),
        ({"forward": "torso"}, "'forward' is a word of the language: call the part something else"),
        ({"to": "torso"}, "'to' is a word of the language: call the part something else"),
        ({"left arm": "torso"}, "'left arm' can't be the name of a part: write letters, digits, and _"),
    ],
)
def test_a_part_that_can_t_be_is_refused(tips: dict[str, str], message: str) -> None:
    with pytest.raises(UrdfError) as refused:
        sections(read_urdf(DOLL.encode()), "doll.urdf", tips=tips)
    assert str(refused.value) == message


@pytest.mark.parametrize(
    ("text", "line", "message", "most"),
    [
        (b" " * (LARGEST_URDF + 1), 0, "it is larger than 5 MB", 0),
        (robot("\n", "<a>" * 80_000).encode(), 2, "more than 100 elements are in one another: no URDF needs that", 103),
        (
            robot("\n" + "<a/>" * 300_000).encode(),
            2,
            "it has more than 200,000 elements and attributes: no robot needs so many",
            200_003,
        ),
        (
            robot("".join(f"<a {ATTRIBUTES}/>" for _ in range(201))).encode(),
            1,
            "it has more than 200,000 elements and attributes: no robot needs so many",
            203,
        ),
        (f"<robot name='{'a' * 200_000}'/>".encode(), 0, "it has a tag or a text of more than 200,000 bytes", 0),
        (f"<robot><a/>{'a' * 300_000}</robot>".encode(), 0, "it has a tag or a text of more than 200,000 bytes", 0),
        (f"<robot>{'<a/>' * 99_999}{' ' * 199_995}".encode(), 1, "this is not XML: no element found", 300_000),
    ],
)
def test_urdfs_that_take_long_to_read_are_refused_early(text: bytes, line: int, message: str, most: int) -> None:
    passed: list[None] = []
    on_checkpoint(lambda: passed.append(None))
    try:
        with pytest.raises(UrdfError) as refused:
            read_urdf(text)
    finally:
        on_checkpoint(None)
    assert (refused.value.line, str(refused.value)) == (line, message)
    assert len(passed) <= most


def test_long_chains_are_read() -> None:
    links = "".join(f'<link name="l{number}"/>' for number in range(3_001))
    chain = "".join(revolute(f"j{number}", f"l{number}", f"l{number + 1}", "0 0 1", "0 0 0") for number in range(3_000))
    assert len(read_urdf(robot(links, chain).encode()).joints) == 3_000


def test_another_parser_finds_the_same_joints() -> None:
    ours = read_urdf(DOLL.encode())
    with contextlib.redirect_stderr(io.StringIO()):  # it lacks the values that the file doesn't have
        theirs = URDF.from_xml_string(DOLL)
    assert theirs.get_root() == ours.root
    pairs = zip(sorted(ours.joints, key=NAME), sorted(theirs.joints, key=NAME), strict=True)
    for joint, other in pairs:
        found = joint.name, joint.kind, joint.parent, joint.child
        assert found == (other.name, other.type, other.parent, other.child)
        assert joint.place == tuple(other.origin.xyz)
        if other.limit:
            assert (joint.lower, joint.upper) == (other.limit.lower, other.limit.upper)
            assert (joint.axis, joint.velocity) == (tuple(other.axis), other.limit.velocity)
