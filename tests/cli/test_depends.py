"""What a command depends on becomes options: declared once, read once, named in errors."""

from inspect import signature
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from ulna.cli.app import OWN, app
from ulna.cli.depends import Depends, command
from ulna.cli.output import Output
from ulna.errors import InputError

Length = Annotated[float, typer.Option("--long")]
CALLS = []


def doubled(*, length: Length = 1.0):
    CALLS.append(length)
    return 2 * length


def squared(double: Annotated[float, Depends(doubled)]):
    return double**2


def run(function, *arguments):
    alone = typer.Typer()
    alone.command()(command(function))
    return CliRunner().invoke(alone, arguments)


def test_options_of_what_a_command_depends_on_are_its_own_and_each_is_read_once():
    def area(double: Annotated[float, Depends(doubled)], square: Annotated[float, Depends(squared)]) -> Output:
        return Output({"double": double, "square": square}, lambda data: [f"{data['double']:g} {data['square']:g}"], status=1)

    CALLS.clear()
    result = run(area, "--long", "3")
    assert (result.stdout, result.exit_code, CALLS) == ("6 36\n", 1, [3.0])
    assert run(area, "--json").stdout == '{"double": 2.0, "square": 4.0}\n'


def test_a_command_without_output_has_no_json():
    def nothing(double: Annotated[float, Depends(doubled)]) -> None:
        pass

    assert run(nothing).exit_code == 0
    assert "as_json" not in signature(command(nothing)).parameters


def test_an_option_that_is_declared_in_two_ways_is_an_error():
    def other(double: Annotated[float, Depends(doubled)], *, length: float = 2.0) -> None:
        pass

    with pytest.raises(TypeError, match="length is declared in two ways"):
        command(other)


def test_an_error_of_the_library_about_a_parameter_names_the_option():
    def refuses(*, length: Length = 1.0) -> None:
        raise InputError("length[2]", f"{length} is too long")

    result = run(refuses)
    assert str(result.exception) == "--long[2]: 1.0 is too long"


def test_an_option_is_the_same_in_every_command_but_for_those_of_one_command_that_share_a_word():
    group, helps = typer.main.get_command(app), {}
    for name in OWN:
        found = group.get_command(typer.Context(group), name)
        for each in getattr(found, "commands", {name: found}).values():
            for parameter in each.params:
                helps.setdefault(parameter.opts[0], set()).add(parameter.help)
    assert {word for word, of in helps.items() if word.startswith("--") and len(of) > 1} == {
        "--robot", "--q", "--xyz", "--csv", "--self", "--to", "--time-limit",
    }  # fmt: skip
    assert not {"--q-seed", "--q-start", "--hulls"} & set(helps)
