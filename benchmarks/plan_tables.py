"""Prints the results of ``plans``: a row for each way and set of problems, and the comparison of their times."""

from collections import defaultdict

import numpy as np

COLUMNS = "problems", "solved", "median us", "mean us", "p95 us", "length", "checks"


def print_table(rows: list[dict]) -> None:
    """Print a row for each way and set of problems: times, lengths, and colliding paths by each judge."""
    judges = sorted({judge for row in rows for judge in row.get("touches", {})})
    print(f"{'':50}" + "".join(f"{name:>10}" for name in COLUMNS) + "".join(f"{f'touch: {name}':>18}" for name in judges))
    for (who, name), some in _by_way(rows).items():
        values = "".join(f"{value:10.5g}" for value in _summary(some))
        touching = ([row["touches"][judge] for row in some if judge in row.get("touches", {})] for judge in judges)
        counts = "".join(f"{str(sum(each)) if each else '-':>18}" for each in touching)
        print(f"{who:32}{name:18}{values}{counts}", flush=True)


def print_ratios(rows: list[dict]) -> None:
    """Print each way's time relative to VAMP's: the median of the ratios, and the ratios of medians and means."""
    times = {
        who: {(row["set"], row["index"]): row["us"] for row in rows if row["who"] == who and row["solved"]} for who in _ways(rows)
    }
    for who, ours in times.items():
        than = "VAMP, not simplified" if "not" in who else "VAMP"
        both = [key for key in ours if key in times.get(than, {})]
        if not both or who == than:
            continue
        mine, theirs = (np.array([each[key] for key in both]) for each in (ours, times[than]))
        ratios = np.percentile(mine / theirs, (25, 50, 75))
        print(
            f"{who} beside {than}: median of the ratios {ratios[1]:.2f} (quartiles {ratios[0]:.2f} to {ratios[2]:.2f}), "
            f"of the medians {np.median(mine) / np.median(theirs):.2f}, of the means {mine.mean() / theirs.mean():.2f}"
        )


def _times(rows: list[dict], who: str) -> dict[tuple[str, int], float]:
    return {(row["set"], row["index"]): row["us"] for row in rows if row["who"] == who and row["solved"]}


def _ways(rows: list[dict]) -> list[str]:
    return list(dict.fromkeys(row["who"] for row in rows))


def _by_way(rows: list[dict]) -> dict[tuple[str, str], list[dict]]:
    groups: dict[tuple[str, str], list[dict]] = defaultdict(list)
    for who in _ways(rows):
        for row in rows:
            if row["who"] == who:
                groups[who, row["set"]].append(row)
        groups[who, "all"] = [row for row in rows if row["who"] == who]
    return groups


def _summary(rows: list[dict]) -> tuple:
    solved = [row for row in rows if row["solved"]]
    if not solved:
        return len(rows), 0, *[np.nan] * 5
    us, lengths, checks = (np.array([row[key] for row in solved]) for key in ("us", "length", "checks"))
    return len(rows), len(solved), np.median(us), us.mean(), np.percentile(us, 95), lengths.mean(), checks.mean()
