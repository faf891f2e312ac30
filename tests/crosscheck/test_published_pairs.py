"""Pairs on which other libraries have failed, or are tested: their numbers, with answers that prove themselves.

FCL, test/test_fcl_signed_distance.cpp (flexible-collision-library/fcl, commit 058c1dd): failures met in the wild, by the number
    of the issue. FCL asserts that the points lie on the shapes, as far apart as the distance says; so do we, and that no
    distance is shorter.
Coal, test/box_box_distance.cpp (nim65s/coal, commit 3d40933).
Drake's fifteen axes of two boxes are in ``test_fifteen_axes.py``.
"""

from functools import partial

import numpy as np
import pytest

import kernel_modes
import solids
import ulna
from assertions import assert_close

MODES = kernel_modes.MODES
SLAB = ulna.Box((0.025, 0.35, 1.845)), "0 -1 0 0.8  1 0 0 -0.4575  0 0 1 1.0225"
BOXES = {
    "issue 388": (
        ((0.03, 0.12, 0.1), """
            -3.0627937852578681533e-08 -0.99999999999999888978 -2.8893865161583314238e-08 0.63499979627350811029
            0.9999999999999980016 -3.0627939739957803544e-08 6.4729926918527511769e-08 -0.48500002215636439651
            -6.4729927722963847085e-08 -2.8893863029448751323e-08 0.99999999999999711342 1.0778146458339641356"""),
        (SLAB[0].extents, SLAB[1]),
    ),
    "issue 395": (
        ((0.46, 0.48, 0.01), "1 0 0 -0.721  0 1 0 -0.772  0 0 1 0.81"),
        ((0.049521, 0.146, 0.0725), """
            0.10758262492983036718 -0.6624881850015212903 -0.74130653817877356637 -0.42677133002999478872
            0.22682184885125472595 -0.709614040775253474 0.6670830248314786326 -0.76596851247746788882
            -0.96797615037608542021 -0.23991106241273435495 0.07392465377049164954 0.80746731400091054098"""),
    ),
    "issue 415": (
        ((0.49, 0.05, 0.21), """4.8966386501092529215e-12 -1 0 -0.44  1 4.8966386501092529215e-12 0 -0.61499999999858001587
            0 0 1 0.355"""),
        ((0.035, 0.12, 0.03), """
            0.83512153565236335595 -0.55006546945762568868 -9.4542360608233572896e-16 -0.40653441507331000704
            0.55006546945762568868 0.83512153565236313391 1.1787444236552387666e-15 -0.69166166923735727945
            1.2902271444330665572e-16 -1.4878153530113264589e-15 1 0.43057093858718892276"""),
    ),
    "issue 398": (((0.614, 3, 0.37), "1 0 0 -0.675  0 1 0 0  0 0 1 0.9115"),
                  ((0.494, 0.552, 0.01), "1 0 0 -0.692  0 1 0 0  0 0 1 0.935")),
    "issue 428": (((0.2, 0.33, 0.1), "1 0 0 -0.071  0 1 0 -0.772  0 0 1 0.8"),
                  ((0.452, 0.27, 0.6), "1 0 0 0.121  0 1 0 -0.78769605692727695523  0 0 1 0.53422044196125151316")),
    "kissing on a table": (
        ((0.3165, 0.2276, 0.1768), """
            0.44540578475530234748 0.89532881496493399442 -8.8937407685638678971e-09 1.2652949075960071568
            -0.89532881496493377238 0.44540578475530190339 -2.8948680226084145336e-08 1.4551012423210101243
            -2.1957263975186326105e-08 2.0856732016652919226e-08 0.99999999999999955591 0.49480006232932938204"""),
        ((0.4943, 0.3546, 0.0752), """
            0.44171122913485860728 0.8971572827861190591 -1.622764514865468214e-09 1.1304016226141906376
            -0.8971572827861190591 0.44171122913485860728 -5.1621053952306079594e-09 1.8410802645284281009
            -3.9144271413829990148e-09 3.7360349218094348098e-09 1 0.44400006232932492933"""),
    ),
    "Drake's issue 21673": (
        ((0.05, 0.55, 0.3), """0.00079632671073326442932 -0.99999968293183538748 0 0.75000000000000055511
            0.99999968293183538748 0.00079632671073326442932 0 -2.4083553715553102684e-15  0 0 1 0.15"""),
        ((0.25, 0.2, 0.15), """6.1232339957367660359e-17 0 1 0.75  -1 6.1232339957367660359e-17 6.1232339957367660359e-17 0
            -6.1232339957367660359e-17 -1 3.7493994566546440196e-33 0.15"""),
    ),
}  # fmt: skip
CYLINDERS = {
    "issue 391": (ulna.Cylinder(radius=0.03, length=0.65), "1 0 0 0.6  0 1 0 0  0 0 1 0.325", ulna.Sphere(0.055),
        """-0.9954758066 -0.0295866301 0.0902914702 0.5419794018  -0.0851034786 -0.1449450565 -0.9857729599 -0.0621175025
        0.0422530022 -0.9889972506 0.1417713719 0.6016236576"""),
    "issue 319": (ulna.Cylinder(radius=0.05, length=0.06),
        """-0.99999999997999022838 6.2572835802045040178e-10 6.3260669852976095481e-06 0.57500009756757608503
        6.3260669851683709551e-06 -6.3943303429958554955e-10 0.99999999997999056145 -0.42711963046787942977
        6.2573180158128459924e-10 1 6.3942912945996747041e-10 1.1867093358746836351""", *SLAB),
    "issue 390": (ulna.Cylinder(radius=0.05, length=0.06),
        """-0.97313010759279283679 -0.12202804064972551379 0.19526123781136842106 0.87472781461138560122
        0.20950801135757171623 -0.11745920593569325607 0.97072639199619581429 -0.4038687881347159947
        -0.095520609678929752073 0.98555187191549953329 0.13986894183635001365 1.5871328698116491385""", *SLAB),
}  # fmt: skip
# Drake's issue 21673, six times: a prism of n sides and radius 1 (a rectangle for 4) against a triangular one that stands in
# it on the same floor: n, the cosine and sine of the prism's turn, where it stands, and the triangle's corners.
PRISMS = [
    (8, 0.77129744817973977522, -0.63647485922966484662, (11.477445682202462862, 9.7785056920756936449),
        ((10.294759, 8.932157), (11.618371, 9.456563), (11.452373, 8.227672))),
    (6, 0.34009658459984087875, -0.94039051098122172778, (4.2864836941313040342, 7.3869576872253679412),
        ((4.149402, 8.493709), (5.188451, 7.476263), (3.931647, 7.374503))),
    (7, -0.76923712747984118732, -0.63896341186844385351, (13.670417904867957049, 13.169816779836704512),
        ((14.835101, 13.060409999999999187), (13.785037, 12.890524), (14.767995, 13.150248))),
    (4, -0.56303944378188575115, -0.82643002410717436579, (15.712812998638135298, 10.219809745800642276),
        ((15.417082, 9.698621), (16.236605, 9.233231), (16.22432, 8.915849))),
    (6, 0.7148738189791493669, -0.69925347545662319693, (6.3335747278141161232, 8.4631576303276716544),
        ((5.242363, 9.122811), (6.359664, 8.28526), (5.670377, 7.598539))),
    (5, -0.085331461972016672823, -0.99635261910516315087, (11.261494468063983021, 5.7102314848013024928),
        ((10.924769, 5.670102), (10.839257, 4.83299), (11.452507, 5.520981))),
]  # fmt: skip


def pose(text):
    return ulna.description.pose.orthonormal(np.vstack([np.array(text.split(), dtype=float).reshape(3, 4), [0, 0, 0, 1]]))


def proved(mode, *pair, exactness=1e-11):
    """The signed distance of one pair, from either side; both answers prove themselves."""
    run, swapped = partial(kernel_modes.run, mode), (*pair[2:], *pair[:2])
    answers = [solids.ask(run, [one]) for one in (pair, swapped)]
    for one, answer in zip((pair, swapped), answers, strict=True):
        solids.assert_proved([one], answer, exactness)
    assert_close(answers[0][0], answers[1][0], atol=exactness)
    return answers[0][0][0], answers[0][1][0], answers[0][2][0]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", BOXES)
def test_boxes_that_stopped_fcl(mode, name):
    (extents_a, T_a), (extents_b, T_b) = BOXES[name]
    d, _, _ = proved(mode, ulna.Box(extents_a), pose(T_a), ulna.Box(extents_b), pose(T_b), exactness=1e-9)
    if name == "kissing on a table":
        assert_close(d, 0, atol=2e-8)  # FCL asks for zero to 2.2e-16 ** 0.5


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("side", [0.01, 0.25, 0.5, 10, 1000])
def test_tilted_boxes_that_all_but_kiss(mode, side):
    """FCL's issue 493: two equal boxes side by side, a few times 1e-16 apart or overlapping."""
    R = pose("""0.94096063217417758029 0.29296840037289501035 0.16959541586174811667 0
        -0.23569836841299879326 0.92661523595848427348 -0.29296840037289506586 0
        -0.2429801799032638987 0.23569836841299884878 0.94096063217417758029 0""")
    for distance in (-1e-15, -2.5e-16, -1e-16, 0, 1e-16, 2.5e-16, 1e-15):
        T_a, T_b = R.copy(), R.copy()
        T_a[:3, 3] = 0, 0, 5 * side
        T_b[:3, 3] = T_a[:3, 3] + R[:3, 1] * (side + distance * max(1, side))
        d, _, _ = proved(mode, ulna.Box((side,) * 3), T_a, ulna.Box((side,) * 3), T_b, exactness=1e-12 * max(1, side))
        assert_close(d, distance * max(1, side), atol=1e-14 * max(1, side))


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", CYLINDERS)
def test_cylinders_that_stopped_fcl(mode, name):
    a, T_a, b, T_b = CYLINDERS[name]
    d, _, _ = proved(mode, a, pose(T_a), b, pose(T_b), exactness=1e-9)
    assert abs(d) < 2e-7


@pytest.mark.parametrize("mode", MODES)
def test_a_ball_that_just_touches_a_box(mode):
    """FCL's issue 408."""
    ball = pose("""-0.99999999999999955591 -4.4637642593504144998e-09 0 1.7855056639081962376e-10
        4.4637642593504144998e-09 -0.99999999999999955591 0 0.04  0 0 1 0.33""")
    d, _, _ = proved(mode, ulna.Sphere(0.06), ball, ulna.Box((0.1,) * 3), pose("1 0 0 0.05  0 1 0 0.15  0 0 1 0.35"))
    assert_close(d, 0, atol=1e-15)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("case", range(len(PRISMS)))
def test_prisms_that_stopped_fcl(mode, case):
    n, cosine, sine, (x, y), corners = PRISMS[case]
    angles = np.arange(n) * 2 * np.pi / n
    outline = np.round(np.transpose([np.cos(angles), np.sin(angles)]), 6)
    if n == 4:
        outline = np.array([(u, v) for u in (-0.92388, 0.92388) for v in (-0.382683, 0.382683)])
    prism = ulna.ConvexMesh([(side, *p) for side in (-0.5, 0.5) for p in outline])
    wedge = ulna.ConvexMesh([(*p, side) for side in (-0.5, 0.5) for p in corners])
    tip = 3.2051032938795742666e-09
    T = pose(f"{tip * sine} {cosine} {sine} {x}  {tip * cosine} {-sine} {cosine} {y}  1 0 {-tip} 0")
    d, _, _ = proved(mode, prism, T, wedge, np.eye(4), exactness=1e-9)
    assert d < -0.1


@pytest.mark.parametrize("mode", MODES)
def test_the_boxes_of_coals_own_tests(mode):
    long, cube, unit = ulna.Box((6, 10, 2)), ulna.Box((2, 2, 2)), ulna.Box((1, 1, 1))
    d, p, q = proved(mode, long, np.eye(4), cube, ulna.pose((25, 20, 5)))
    assert_close(d, np.sqrt(21**2 + 14**2 + 3**2), atol=1e-13)
    assert_close([p, q], [(3, 5, 1), (24, 19, 4)], atol=1e-13)
    half = np.sin(np.pi / 8) / np.sqrt(3)
    d, p, q = proved(mode, long, np.eye(4), cube, ulna.pose((0, 0, 10), wxyz=(np.cos(np.pi / 8), half, half, half)))
    assert_close(d, 9 - 1.62123444, atol=1e-8)
    assert_close([p, q], [(0.60947571, 0.01175873, 1), (0.60947571, 0.01175873, 10 - 1.62123444)], atol=1e-8)
    turned, tilted = ulna.pose((-2, 1, 0.5), rpy=(0, 0, np.pi / 4)), ulna.pose((2, 0.5, 0.5), rpy=(0, np.pi / 4, 0))
    d, p, q = proved(mode, unit, turned, unit, tilted)
    assert_close(d, 4 - np.sqrt(2), atol=1e-14)
    assert_close([p, q], [(np.sqrt(0.5) - 2, 1, 0.5), (2 - np.sqrt(0.5), 1, 0.5)], atol=1e-14)
    for x, expected in ((2, 1), (1.01, 0.01), (0.99, -0.01), (0, -1)):
        assert_close(proved(mode, unit, ulna.pose((x, 0, 0)), unit, np.eye(4))[0], expected, atol=1e-15)
