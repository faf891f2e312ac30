"""Makes commands of functions: their dependencies become options, their return value is printed.

A parameter of a command is an option that typer declares, or ``Annotated[Robot, Depends(load_robot)]``. In the second case its
value is the result of ``load_robot``, whose parameters become options of the command. So each option is declared, read and
checked in one place, and a command names what it needs.
"""

import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import update_wrapper
from inspect import Parameter, Signature, signature
from typing import Annotated, Any, get_args

import typer

from ulna.cli.output import Output, show, warn
from ulna.errors import InputError, UnitWarning

Json = Annotated[bool, typer.Option("--json", help="One JSON object instead of tables: meters and radians, infinity is null.")]


@dataclass(frozen=True)
class Depends:
    """Annotation of a parameter whose value a function returns; the function's parameters become options."""

    function: Callable[..., Any]


def command(function: Callable[..., Output | None]) -> Callable[..., None]:
    """Wrap a function for typer.

    The options are the function's own, then those of the functions on which it depends, and ``--json`` if it returns an
    ``Output``, which is printed. An ``InputError`` about a parameter names the option.
    """
    options = _options(function)
    if signature(function, eval_str=True).return_annotation is Output:
        as_json = Parameter("as_json", Parameter.KEYWORD_ONLY, default=False, annotation=Json)
        options["as_json"] = options.pop("as_json", as_json)  # move it to the end

    def run(context: typer.Context, **given: Any) -> None:
        names = {
            each.name: each.metavar if each.param_type_name == "argument" else each.opts[0] for each in context.command.params
        }
        warnings.filterwarnings("ignore", "rpy: ", UnitWarning)  # options of angles warn about degrees with their own names
        with as_options(names), unit_warnings_printed():
            output = _call(function, given, {})
        if output is not None:
            show(output, as_json=given["as_json"])
            raise typer.Exit(output.status)

    context = Parameter("context", Parameter.POSITIONAL_OR_KEYWORD, annotation=typer.Context)
    update_wrapper(run, function, assigned=("__name__", "__doc__", "__module__"))
    vars(run)["__signature__"] = Signature([context, *options.values()])
    return run


@contextmanager
def unit_warnings_printed() -> Iterator[None]:
    """Within the block, print warnings about units as lines on standard error, without the source line of the program."""
    usual = warnings.showwarning

    def show_warning(message: Warning | str, category: type[Warning], *place: Any) -> None:
        warn(str(message)) if issubclass(category, UnitWarning) else usual(message, category, *place)

    warnings.showwarning = show_warning
    try:
        yield
    finally:
        warnings.showwarning = usual


@contextmanager
def as_options(names: Mapping[str, str | None]) -> Iterator[None]:
    """Within the block, an ``InputError`` of the library names the option instead of the argument.

    Args:
        names: The option of each argument, as in ``{"q_start": "--from"}``.
    """
    try:
        yield
    except InputError as error:
        argument, bracket, index = error.argument.partition("[")
        raise InputError((names.get(argument) or argument) + bracket + index, error.message) from None


def defaults_of(function: Callable[..., Any]) -> dict[str, Any]:
    """The default values of a function of the library, by parameter; the options share them."""
    return {name: each.default for name, each in signature(function).parameters.items() if each.default is not Parameter.empty}


def _options(function: Callable[..., Any]) -> dict[str, Parameter]:
    """The options of a command by parameter name: its own first, then those of the functions on which it depends.

    The options of a function without dependencies replace the parameter in its place.
    """
    options: dict[str, Parameter] = {}
    functions = [function]
    for each in functions:  # the list grows in the loop
        for parameter, source in _parameters(each):
            here = [(parameter, source)] if source is None else list(_parameters(source))
            if any(further is not None for _, further in here):
                functions += [] if source in functions else [source]
                continue
            for option in (one.replace(kind=Parameter.KEYWORD_ONLY) for one, _ in here):
                if options.setdefault(option.name, option) != option:
                    raise TypeError(f"{option.name} is declared in two ways")
    return options


def _call(function: Callable[..., Any], given: Mapping[str, Any], known: dict[Callable[..., Any], Any]) -> Any:
    """Call a function with the given options; each function is called once."""
    if function not in known:
        values = {
            parameter.name: given[parameter.name] if source is None else _call(source, given, known)
            for parameter, source in _parameters(function)
        }
        known[function] = function(**values)
    return known[function]


def _parameters(function: Callable[..., Any]) -> Iterator[tuple[Parameter, Callable[..., Any] | None]]:
    """The parameters of a function, each with the function of its ``Depends``, or None."""
    for parameter in signature(function, eval_str=True).parameters.values():
        yield parameter, next((each.function for each in get_args(parameter.annotation) if isinstance(each, Depends)), None)
