"""Lists the files of a reachability map, and defines a small map of the Panda."""

SMALL = {"voxel": 0.3, "orientations": 8}  # 2744 poses


def files_of(path):
    """The bytes of every file of a map, by its place in it; what a killed writer has left half written is left out."""
    files = (file for file in path.rglob("*") if file.is_file() and file.suffix != ".partial")
    return {file.relative_to(path).as_posix(): file.read_bytes() for file in files}


def verdicts_of(path):
    """The files of the verdicts: one for each chunk that is done."""
    return sorted(file for file in (path / "reached" / "c").rglob("*") if file.is_file() and file.suffix != ".partial")
