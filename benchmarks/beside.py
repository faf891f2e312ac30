"""Makes the table that compares libraries: each library's time as a multiple of Ulna's, by kind of work."""

PEERS = {
    "Pinocchio": "pin",
    "Robotics Toolbox": "roboticstoolbox-python",
    "MuJoCo": "mujoco",
    "TRAC-IK": "pytracik",
    "EAIK": "EAIK",
    "ikpy": "ikpy",
}

WORDS = {"itself": "self-collision", "a row of 2048": "a row of a batch of 2,048"}


def beside_rows(data: dict) -> list[dict[str, str]]:
    """A row for each kind of work. Above 1 Ulna is faster; a figure below 1 is bold."""
    fk, batches = data["forward_kinematics"], data["batches"]
    rows = [
        _row("one forward kinematics, Panda", _times(fk, robot="panda")),
        _row("the same, Pinocchio's placement object kept", _times(fk, ", placement kept", robot="panda")),
        _row("one Jacobian, Panda", _times(data["jacobian"], robot="panda")),
        _row(
            "4,096 forward kinematics, Panda; the others in a loop",
            _times(batches, ", in a loop", robot="panda", work="forward_kinematics, 4096 at once"),
        ),
        *(
            _row(f"one inverse kinematics, {name}", _times(data["protocols"], robot=robot, protocol="reachable"))
            for robot, name in (("panda", "Panda"), ("ur5", "UR5"))
        ),
    ]
    for row in data["collision"]:
        scene, calls = (WORDS.get(row[key], row[key]) for key in ("scene", "asked"))
        name = f"{row['query']}, {scene} ({row['pairs']:,} pairs), {calls}"
        rows.append(_row(name, {"pin": row["times_ulna"]}))
    return rows


def solved(data: dict) -> str:
    """The share of targets that each library solved."""
    said = []
    for robot, name in (("panda", "Panda"), ("ur5", "UR5")):
        found = {row["library"]: row for row in data["protocols"] if row["robot"] == robot and row["protocol"] == "reachable"}
        names = {"Ulna": "ulna", **PEERS}
        shares = [f"{peer} {found[key]['solved_percent']:.4g} %" for peer, key in names.items() if key in found]
        said.append(f"{name}, {found['ulna']['targets']:,} targets: {', '.join(shares)}.")
    return " ".join(said)


def _times(rows: list[dict], suffix: str = "", **which: str) -> dict[str, float]:
    chosen = [row for row in rows if all(row[key] == value for key, value in which.items())]
    return {row["library"].removesuffix(suffix): row["times_ulna"] for row in chosen if row["library"].endswith(suffix)}


def _row(work: str, times: dict[str, float]) -> dict[str, str]:
    return {"work": work, **{peer: _figure(times.get(name)) for peer, name in PEERS.items()}}


def _figure(times: float | None) -> str:
    """Format with two digits; bold if the other library is faster."""
    if times is None:
        return "-"
    if times < 1:
        return f"**{times:.2f}**"
    return f"{times:.2g}" if times < 100 else f"{float(f'{times:.2g}'):.0f}"
