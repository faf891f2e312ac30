"""A valid description, variants with one defect each, and the findings that each variant must have."""

import re

from ulna import Severity

SOUND = """<robot name="arm">
  <link name="base">
    <visual><geometry><sphere radius="0.1"/></geometry></visual>
    <collision><geometry><cylinder radius="0.1" length="0.2"/></geometry></collision>
  </link>
  <link name="upper">
    <inertial><mass value="2"/><inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"/></inertial>
    <visual><origin xyz="0 0 0.2" rpy="0 1.57 0"/><geometry><box size="0.1 0.1 0.4"/></geometry></visual>
    <collision><geometry><box size="0.1 0.1 0.4"/></geometry></collision>
  </link>
  <link name="left">LIGHT</link>
  <link name="right">LIGHT</link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" velocity="2" effort="3"/>
    <safety_controller k_velocity="9" k_position="8" soft_lower_limit="-0.9" soft_upper_limit="0.9"/>
  </joint>
  <joint name="grip" type="prismatic">
    <parent link="upper"/><child link="left"/><origin xyz="0 0 0.5"/><axis xyz="1 0 0"/>
    <limit lower="0.1" upper="0.4" velocity="2" effort="3"/>
  </joint>
  <joint name="grip too" type="prismatic">
    <parent link="upper"/><child link="right"/><axis xyz="-1 0 0"/>
    <limit lower="0" upper="0.4" velocity="2" effort="3"/><mimic joint="grip" multiplier="0.5"/>
  </joint>
</robot>
"""
LIGHT = '<inertial><mass value="0.1"/><inertia ixx="1e-4" ixy="0.0" ixz="0.0" iyy="1e-4" iyz="0.0" izz="1e-4"/></inertial>'
SOUND = SOUND.replace("LIGHT", LIGHT)
INERTIA = 'ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"'
ERROR, WARNING, NOTE = Severity
# What is written, what is written instead, and the findings: severity, where, the beginning of the message.
DEFECTS = {
    "limits that cross": ('lower="-1"', 'lower="1.5"', [(ERROR, "document", "joint 'shoulder': lower limit 1.5 is above upper")]),
    "limits that meet": (
        'lower="-1"',
        'lower="1"',
        [(WARNING, "joint 'shoulder'", "lower and upper limit are both 1: it cannot")],
    ),
    "limits not given": (
        'lower="-1" upper="1"',
        "",
        [(WARNING, "joint 'shoulder'", "lower and upper limit are not given, so both 0")],
    ),
    "limits in degrees": ('lower="-1"', 'lower="-170"', [(WARNING, "joint 'shoulder'", "limits -170 to 1 rad .* degrees?")]),
    "limits that mean none": ('lower="-1"', 'lower="-1e9"', [(WARNING, "joint 'shoulder'", "limits .* of type 'continuous'")]),
    "limits in millimeters": (
        'upper="0.4" v',
        'upper="400" v',
        [
            (WARNING, "joint 'grip'", "limits 0.1 to 400 m: millimeters?"),
            (WARNING, "joint 'grip too'", "limits 0 to 400 m"),
            (WARNING, "document", "it reaches 401 m when stretched: millimeters?"),
        ],
    ),
    "no velocity": (
        'upper="1" velocity="2"',
        'upper="1"',
        [
            (NOTE, "joint 'shoulder'", "no velocity limit: treated as unlimited"),
        ],
    ),
    "no effort to give": (
        'upper="1" velocity="2" effort="3"',
        'upper="1" velocity="2" effort="0"',
        [
            (WARNING, "joint 'shoulder'", "effort limit is 0"),
        ],
    ),
    "a follower without room": (
        'multiplier="0.5"',
        'multiplier="-0.5"',
        [
            (WARNING, "joint 'grip too'", "its limits leave no range for 'grip', which it mimics: they are ignored"),
        ],
    ),
    "a follower that stands still": (
        'multiplier="0.5"',
        'multiplier="0"',
        [(WARNING, "joint 'grip too'", "mimics 'grip' with multi")],
    ),
    "a follower of nothing": (
        'mimic joint="grip"',
        'mimic joint="gripp"',
        [
            (ERROR, "document", "joint 'grip too' mimics 'gripp', which is not defined; did you mean 'grip'?"),
        ],
    ),
    "an axis of another length": (
        '"-1 0 0"',
        '"-1 0 1"',
        [(WARNING, "joint 'grip too'", 'axis "-1 0 1" has length 1.414: normalized')],
    ),
    "an axis without direction": ('"-1 0 0"', '"0 0 0"', [(ERROR, "document", "joint 'grip too': axis .* has no direction")]),
    "no axis": ('<axis xyz="-1 0 0"/>', "", [(NOTE, "joint 'grip too'", "no <axis>: the x axis is used")]),
    "an angle in degrees": (
        'rpy="0 1.57 0"',
        'rpy="0 90 0"',
        [(WARNING, "link 'upper'", 'rpy="0 90 0" is more than a turn: degrees?')],
    ),
    "names that differ by case": ('"left"', '"Upper"', [(WARNING, "link 'Upper'", "differs from 'upper' by case only")]),
    "a name twice": (
        'name="left"',
        'name="upper"',
        [
            (ERROR, "document", "link 'upper' is defined twice"),
            (ERROR, "joint 'grip'", "<child> link 'left' is not defined"),
        ],
    ),
    "an element misspelt": (
        "<limit lower",
        "<limits lower",
        [
            (ERROR, "document", "joint 'shoulder': a revolute joint needs a <limit>"),
            (ERROR, "joint 'grip'", "a prismatic joint without <limit>"),
            *[
                (WARNING, f"joint '{name}'", "<limits> in <joint> is not known, and left out; did you mean <limit>?")
                for name in ("shoulder", "grip", "grip too")
            ],
        ],
    ),
    "an attribute misspelt": (
        'lower="-1"',
        'lowr="-1"',
        [(WARNING, "joint 'shoulder'", "attribute 'lowr' .* did you mean 'lower'?")],
    ),
    "an element that is not used": (
        '<axis xyz="-1 0 0"/>',
        '<axis xyz="-1 0 0"/><calibration rising="1"/>',
        [
            (NOTE, "document", "1 <calibration> in <joint> not used"),
        ],
    ),
    "an element that closes a loop": (
        "</robot>",
        '<loop_joint name="l" type="spherical"><link1 link="left"/><link2 link="base"/></loop_joint></robot>',
        [(WARNING, "document", "<loop_joint> in <robot> is not read: it closes a loop")],
    ),
    "a joint of Gazebo": (
        "</robot>",
        '<gazebo><joint name="l" type="revolute"/></gazebo></robot>',
        [(WARNING, "document", "a <joint> in <gazebo> is not read")],
    ),
    "velocity limits of another format": (
        '<axis xyz="-1 0 0"/>',
        '<axis xyz="-1 0 0"/><position_based_velocity_limits velocity_offset="0.2"/>',
        [(WARNING, "joint 'grip too'", "<position_based_velocity_limits> in <joint> is not read")],
    ),
    "an attribute of a limit that is not known": (
        'upper="1" velocity="2"',
        'upper="1" slack="1" velocity="2"',
        [(WARNING, "joint 'shoulder'", "attribute 'slack' of <limit> is not read")],
    ),
    "numbers as the text of an element": (
        '<axis xyz="-1 0 0"/>',
        '<axis xyz="-1 0 0"/><origin>0 0 0.1 0 0 0</origin>',
        [(WARNING, "joint 'grip too'", "the text '0 0 0.1 0 0 0' in <origin> is not read")],
    ),
    "an acceleration in an older version": (
        'upper="1" velocity="2"',
        'upper="1" acceleration="0" velocity="2"',
        [(WARNING, "joint 'shoulder'", "acceleration '0' is not a number above 0, so it sets no limit")],
    ),
    "a version that is none": (
        '<robot name="arm"',
        '<robot name="arm" version="1"',
        [(WARNING, "document", "version '1' is not two")],
    ),
    "a version of the future": (
        '<robot name="arm"',
        '<robot name="arm" version="1.3"',
        [(ERROR, "document", "is URDF 1.3; versions up to 1.2 are read")],
    ),
    "a word for a number": ('upper="1"', 'upper="one"', [(ERROR, "document", "<limit> upper='one': not numbers")]),
    "two words for numbers": (
        'lower="-1" upper="1"',
        'lower="minus" upper="one"',
        [
            (ERROR, "document", "<limit> lower='minus': not numbers"),
            (ERROR, "joint 'shoulder'", '<limit> upper="one": 1 finite number'),
        ],
    ),
    "a type that is not known": ('"revolute"', '"hinge"', [(ERROR, "document", "joint 'shoulder': type 'hinge' is not known")]),
    "a flat collision shape": ('length="0.2"', 'length="0"', [(WARNING, "link 'base'", "collision cylinder has no volume")]),
    "a shape in millimeters": (
        'length="0.2"',
        'length="200"',
        [(WARNING, "link 'base'", "collision cylinder is 0.2 x 0.2 x 200 m: milli")],
    ),
    "a shape scaled twice": (
        '<sphere radius="0.1"/>',
        '<sphere radius="1e-4"/>',
        [
            (WARNING, "link 'base'", "visual sphere is 0.0002 x 0.0002 x 0.0002 m: smaller than a millimeter"),
        ],
    ),
    "a link that collides with nothing": (
        '<collision><geometry><box size="0.1 0.1 0.4"/></geometry></collision>',
        "",
        [
            (WARNING, "document", "a visual shape and no collision shape: upper"),
        ],
    ),
    "no mass": ('value="2"', 'value="0"', [(WARNING, "link 'upper'", "mass is 0 kg")]),
    "no inertia": (INERTIA, re.sub(r"0\.\d", "0", INERTIA), [(WARNING, "link 'upper'", "inertia is zero")]),
    "neither": (
        '<mass value="2"/><inertia ' + INERTIA,
        '<mass value="0"/><inertia ' + re.sub(r"0\.\d", "0", INERTIA),
        [
            (WARNING, "link 'upper'", "has a mass of 0 kg and is moved, by shoulder"),
            (NOTE, "document", "mass and inertia are zero: upper"),
        ],
    ),
    "damping": (
        '<axis xyz="-1 0 0"/>',
        '<axis xyz="-1 0 0"/><dynamics damping="1"/>',
        [(NOTE, "document", "damping and friction are read and written, but no torque includes them")],
    ),
    "damping that is not a number": (
        '<axis xyz="-1 0 0"/>',
        '<axis xyz="-1 0 0"/><dynamics damping="lots"/>',
        [(WARNING, "joint 'grip too'", "<dynamics> damping='lots': not numbers: damping is taken as 0")],
    ),
    "damping misspelt": (
        '<axis xyz="-1 0 0"/>',
        '<axis xyz="-1 0 0"/><dynamics dampign="1"/>',
        [(WARNING, "joint 'grip too'", "attribute 'dampign' of <dynamics> is not known, and left out; did you mean 'damping'?")],
    ),
    "a negative mass": (
        'value="2"',
        'value="-2"',
        [
            (WARNING, "link 'upper'", "<mass> value='-2': 1 finite number of at least 0 expected: this inertia is left out"),
            (WARNING, "document", "moved, but without an inertia, which other links have: upper"),
        ],
    ),
    "a moment that is not a number": (
        'izz="0.3"',
        'izz="nan"',
        [
            (WARNING, "link 'upper'", "<inertia> izz='nan': 1 finite number expected: this inertia is left out"),
            (WARNING, "document", "moved, but without an inertia, which other links have: upper"),
        ],
    ),
    "a moment too large to compute with": (
        'izz="0.3"',
        'izz="1e300"',
        [
            (WARNING, "link 'upper'", "a mass or a moment is beyond 1e[+]12: this inertia is left out"),
            (WARNING, "document", "moved, but without an inertia, which other links have: upper"),
        ],
    ),
    "no mass element": (
        '<mass value="2"/>',
        "",
        [
            (WARNING, "link 'upper'", "<inertial> has no <mass>: this inertia is left out"),
            (WARNING, "document", "moved, but without an inertia, which other links have: upper"),
        ],
    ),
    "links without inertia": (
        LIGHT,
        "",
        [(WARNING, "document", "moved, but without an inertia, which other links have: left, right")],
    ),
    "grams": (
        '<mass value="2"/>',
        '<mass value="2000"/>',
        [
            (WARNING, "link 'upper'", r"denser than any metal, 1.1e[+]05 kg/m.3. Grams?"),
            (WARNING, "document", "the masses are 2000 kg in sum: grams?"),
        ],
    ),
    "kg mm^2": (
        INERTIA,
        INERTIA.replace("0.", "20000."),
        [(WARNING, "link 'upper'", "moments of a body many times larger, 2e[+]04 kg m.2. Are these g mm.2 or kg mm.2?")],
    ),
    "a center of mass in the frame of the base": (
        '<mass value="2"/>',
        '<origin xyz="0 0 0.9"/><mass value="2"/>',
        [(WARNING, "link 'upper'", r"its center of mass \(0, 0, 0.9\) is 0.\d+ m off its shapes, which are 0.\d+ m across")],
    ),
    "an indefinite inertia": (
        'ixy="0"',
        'ixy="0.5"',
        [(WARNING, "link 'upper'", "inertia is not positive definite: a moment of -0.3")],
    ),
    "an inertia of no body": (
        'izz="0.3"',
        'izz="0.5"',
        [(WARNING, "link 'upper'", "inertia of no real body: moments 0.2 [+] 0.2 < 0.5")],
    ),
    "a mesh that is not there": (
        '<sphere radius="0.1"/>',
        '<mesh filename="ball.stl"/>',
        [
            (WARNING, "link 'base'", "1 mesh of folder '.' not found: ball.stl"),
        ],
    ),
    "an arm in millimeters": ("0 0 0.3", "0 0 300", [(WARNING, "document", "it reaches 301 m when stretched: millimeters?")]),
}
