"""URDFs: their joints, the reasons for which some are refused, and the sections of `improv.toml` made from them."""

from __future__ import annotations

import contextlib
import io
import math
from inspect import cleandoc
from operator import attrgetter

import pytest
from hypothesis import given
from hypothesis import strategies as st
from urdf_parser_py.urdf import URDF

from improv_core.program.analysis import analyze
from improv_core.robots.bodies import DIRECTIONS
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

PARTS = """\
# From doll.urdf. Check to which side each direction moves its joint, and how far in a beat.
# A guess: the joint moves its part in no clear direction, or another joint has that one.
[profiles.doll]
step = 0.2 # meters that its base drives in a beat: write yours
joint_states = "joint_states"

[profiles.doll.body.waist] # what moves torso
left = { joint = "waist", degrees = -30 }

[profiles.doll.body.left_arm] # what moves left_hand
mirror = "right_arm"
up = { joint = "left_shoulder", degrees = -30 }
left = { joint = "left_elbow", degrees = 30 }

[profiles.doll.body.right_arm] # what moves right_hand
up = { joint = "right_shoulder", degrees = -30 }
left = { joint = "right_elbow", degrees = 30 }

[profiles.doll.joints.waist]
min = -90
max = 120
max_velocity = 90
"""


def test_joints_up_to_a_fork_and_from_there_to_an_end_are_parts_and_left_mirrors_right() -> None:
    made = sections(read_urdf(DOLL.encode()), "doll.urdf")
    assert made.startswith(PARTS)
    assert made.endswith("max_velocity = 90\n")


def test_proposed_sections_can_be_used_as_they_are() -> None:
    toml = sections(read_urdf(DOLL.encode()), "doll.urdf", tips={"arm": "left_hand", "whole": "right_hand"})
    robots = read_robots(f'{toml}\n[robots.ada]\nprofile = "doll"\n')
    assert robots.diagnostics == ()
    assert analyze("ada $ arm (up left) || whole (up up)", robots).diagnostics == ()


def check_parts(joints: str, parts: str) -> None:
    """Check the parts of joints, and the groups of these. Each joint is a type, an axis, and a name; the one after
    `|NAME` is carried by the joint NAME, and all others by the one before. Each is 0.3 m ahead of its carrier."""
    inside, carrier = ['<link name="base"/>'], "base"
    for each in joints.split():
        if each.startswith("|"):
            carrier = each[1:]
            continue
        kind, axis, name = each.split(":")
        limit = "" if kind == "continuous" else '<limit lower="-1" upper="1" velocity="1"/>'
        ends = f'<parent link="{carrier}"/><child link="{name}"/><origin xyz="0.3 0 0"/>'
        inside.append(
            f'<link name="{name}"/><joint name="{name}" type="{kind}">{ends}<axis xyz="{axis}"/>{limit}</joint>'
        )
        carrier = name
    text = robot(*inside).replace('"x"', '"1 0 0"').replace('"y"', '"0 1 0"').replace('"z"', '"0 0 1"')
    config = read_robots(sections(read_urdf(text.encode()), "x.urdf"))
    assert config.diagnostics == ()
    body = config.profiles["doll"].body
    assert body
    words = {component: word for word, component in DIRECTIONS.items()}
    found = [
        f"{each.name}: {' '.join(f'{words[way.direction]} {way.joint}' for way in each.drives)}" for each in body.parts
    ]
    found += [f"{each.name} = {' '.join(each.parts)}" for each in body.groups]
    assert "\n".join(found) == cleandoc(parts)


UNNAMED = "revolute:z:j1 revolute:y:j2 revolute:z:j3 revolute:y:j4 revolute:x:j5 revolute:y:j6 revolute:x:j7"
INDUSTRIAL = "revolute:z:j1 revolute:y:j2 revolute:y:j3 revolute:x:j4 revolute:y:j5 revolute:x:j6"


@pytest.mark.parametrize(
    ("joints", "parts"),
    [
        (
            UNNAMED,
            """
            shoulder: left j1 up j2 strafeleft j3
            elbow: up j4
            wrist: strafeleft j5 up j6 left j7
            arm = shoulder elbow wrist
            """,
        ),
        (
            f"{INDUSTRIAL} prismatic:y:finger",
            """
            shoulder: left j1 up j2
            elbow: up j3
            wrist: strafeleft j4 up j5 left j6
            hand: strafeleft finger
            arm = shoulder elbow wrist hand
            """,
        ),
        (
            "revolute:z:LHipYaw revolute:x:LHipRoll revolute:y:LHipPitch revolute:y:LKnee revolute:y:LAnkle",
            """
            left_hip: left LHipYaw strafeleft LHipRoll up LHipPitch
            left_knee: up LKnee
            left_ankle: up LAnkle
            left_leg = left_hip left_knee left_ankle
            """,
        ),
        (
            "revolute:x:FL_hip revolute:y:FL_thigh revolute:y:FL_calf |base revolute:x:FR_hip revolute:y:FR_thigh",
            """
            fl_leg: strafeleft FL_hip up FL_thigh forward FL_calf
            fr_leg: strafeleft FR_hip up FR_thigh
            """,
        ),
        (
            "revolute:z:waist revolute:z:neck_pan revolute:y:neck |waist revolute:y:r_elbow |waist revolute:y:l_elbow",
            """
            waist: left waist
            neck: left neck_pan up neck
            right_elbow: up r_elbow
            left_elbow: up l_elbow
            """,
        ),
        (
            "revolute:y:r2/left_elbow |base revolute:y:r2/right_elbow",
            """
            left_elbow: up r2/left_elbow
            right_elbow: up r2/right_elbow
            """,
        ),
        (
            "revolute:z:arm_1 revolute:y:arm_2 prismatic:y:left_finger |arm_2 prismatic:y:right_finger",
            """
            arm: left arm_1 up arm_2
            left_finger: strafeleft left_finger
            right_finger: strafeleft right_finger
            hand = left_finger right_finger
            """,
        ),
        (
            f"revolute:z:l_wrist {' '.join(f'revolute:y:thumb_{each}' for each in range(5))} |l_wrist revolute:y:ring",
            """
            left_wrist: left l_wrist
            thumb_3: up thumb_0 forward thumb_1 left thumb_2 strafeleft thumb_3
            thumb_4_2: up thumb_4
            ring: up ring
            thumb_4 = thumb_3 thumb_4_2
            left_hand = thumb_3 thumb_4_2 ring
            """,
        ),
        (
            " ".join(f"revolute:y:index_{number}" for number in range(5)),
            """
            index_3: up index_0 forward index_1 left index_2 strafeleft index_3
            index_4_2: up index_4
            index_4 = index_3 index_4_2
            """,
        ),
        (
            "continuous:y:left_wheel |base continuous:z:swivel continuous:y:roller |base continuous:z:turret",
            """
            turret: left turret
            """,
        ),
    ],
)
def test_parts_are_what_people_would_name(joints: str, parts: str) -> None:
    check_parts(joints, parts)


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
        ("revolute", "1 0 0", "0 0 0", "1 0 0", "strafeleft = { joint = 'j', degrees = -30 } # a guess"),
        ("revolute", "0 1 0", "0 0 0", "0 0 0", "up = { joint = 'j', degrees = -30 }"),
        ("prismatic", "1 0 0", f"0 {-math.pi / 2} 0", "0 0 0", "up = { joint = 'j', meters = 0.05 }"),
        ("prismatic", "0 -2 0", "0 0 0", "0 0 0", "strafeleft = { joint = 'j', meters = -0.05 }"),
        ("prismatic", "1 1 1", "0 0 0", "0 0 0", "up = { joint = 'j', meters = 0.05 } # a guess"),
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
        "# wheel: it seems to drive the base; --part NAME=e makes it a part",
    ]


@pytest.mark.parametrize(
    ("kind", "limit", "direction", "section"),
    [
        ("revolute", '<limit lower="-1" upper="2" velocity="1000"/>', "degrees = 30", "min = -57.2958\nmax = 114.5916\n"
        "# The file's speed limit, 57295.7795, is none that a robot has: write a max_velocity.\n"),
        ("revolute", '<limit lower="-1" upper="1" velocity="-1"/>', "degrees = 30", "min = -57.2958\nmax = 57.2958\n"
        "# The file's speed limit, -57.2958, is none that a robot has: write a max_velocity.\n"),
        ("revolute", '<limit lower="-1e6" upper="1e6" velocity="1"/>', "degrees = 30",
        "# The file's min, -57295779.51, is none that a robot has.\n"
        "# The file's max, 57295779.51, is none that a robot has.\nmax_velocity = 57.2958\n"),
        ("revolute", '<limit lower="1" upper="1e6" velocity="0.2"/>', "degrees = 7.5", "min = 57.2958\n"
        "# The file's max, 57295779.51, is none that a robot has.\nmax_velocity = 11.4592\n"
        "start = 57.2958 # within its limits, which don't include 0\n"),
        ("prismatic", '<limit lower="0.2" upper="0.23" velocity="0"/>', "meters = 0.0125", "min = 0.2\nmax = 0.23\n"
        "# The file sets no speed limit: write a max_velocity.\n"
        "start = 0.215 # within its limits, which don't include 0\n"),
        ("prismatic", "", "meters = 0.05", "# The file sets no min.\n# The file sets no max.\n"
        "# The file sets no speed limit: write a max_velocity.\n"),
        ("continuous", "", "degrees = 30", "# The file sets no speed limit: write a max_velocity.\n"),
    ],
)  # fmt: skip
def test_limits_are_those_of_the_file_that_improv_toml_accepts(
    kind: str, limit: str, direction: str, section: str
) -> None:
    inside = f'<joint name="j" type="{kind}">{ENDS}<axis xyz="0 0 1"/>{limit}</joint>'
    toml = sections(read_urdf(robot(LINKS, inside).encode()), "x.urdf")
    assert f'joint = "j", {direction} }}' in toml
    assert toml.endswith(f"joints.j]\n{section}")
    assert read_robots(toml).diagnostics == ()


def test_a_profile_has_no_name_of_a_built_in_one() -> None:
    assert "[profiles.husky_2]\n" in sections(read_urdf(DOLL.replace('"doll"', '"husky"').encode()), "x.urdf")


@pytest.mark.parametrize("kind", ["continuous:y:left_wheel", "fixed:y:j", "revolute:y:blocked"])
def test_a_robot_in_which_nothing_can_dance_is_refused(kind: str) -> None:
    what, _, name = kind.split(":")
    inside = f'<joint name="{name}" type="{what}">{ENDS}<axis xyz="0 1 0"/><limit velocity="1"/></joint>'
    with pytest.raises(UrdfError, match="nothing in it can dance"):
        sections(read_urdf(robot(LINKS, inside).encode()), "x.urdf")


NUMBERS = st.sampled_from(["0", "1", "-1", "0.3", "-0.02", "0.001", "3.2", "1000", "-1e6", "1e-9", "1e308", "nan", "x"])
VECTORS = st.sampled_from(["0 0 1", "0 1 0", "1 0 0", "0 0 0", "0.5 0.5 0.7", "-1 0 1e-9", "1e300 0 1e300", "1 2"])
NAMES = st.sampled_from(["LShoulder", "l_elbow", "r_elbow", "wheel", "forward", "to", "2", "-", "ä", "husky", "."])


@given(st.data())
def test_whatever_a_urdf_says_it_is_refused_in_words_or_its_sections_can_be_used(data: st.DataObject) -> None:
    def any_joint(number: int) -> str:
        kind = data.draw(st.sampled_from(["revolute", "continuous", "prismatic", "fixed", "floating"]))
        carrier = data.draw(st.integers(0, number))
        limit = " ".join(f'{key}="{data.draw(NUMBERS)}"' for key in data.draw(st.sets(st.sampled_from(LIMITS))))
        mimic = '<mimic joint="j0"/>' if data.draw(st.integers(0, 9)) == 0 else ""
        return (
            f'<link name="{number + 1}"/><joint name="{data.draw(NAMES)}{number}" type="{kind}">{mimic}'
            f'<parent link="{carrier}"/><child link="{number + 1}"/><axis xyz="{data.draw(VECTORS)}"/>'
            f'<origin xyz="{data.draw(VECTORS)}" rpy="{data.draw(VECTORS)}"/><limit {limit}/></joint>'
        )

    joints = map(any_joint, range(data.draw(st.integers(1, 12))))
    text = f'<robot name="{data.draw(NAMES)}"><link name="0"/>{"".join(joints)}</robot>'
    with contextlib.suppress(UrdfError):
        toml = sections(read_urdf(text.encode()), "x.urdf")
        assert [each.message for each in read_robots(toml).diagnostics] == [], toml


LIMITS = ("lower", "upper", "velocity", "effort")


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
