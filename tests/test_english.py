"""The checker of English finds what it is for, and leaves correct prose, code and formulas alone."""

import pytest

import english
from english import CheckRegistry, Config, Piece, docstrings_of, general_faults, own_faults, paragraphs_of

LONG = "A sentence has far more words than one can hold in the head at once, if it goes on and on and on and on and on and on."


def faults(*paragraphs, is_docstring=False):
    return list(own_faults(Piece(1, list(paragraphs), is_docstring=is_docstring)))


@pytest.mark.parametrize(
    ("paragraph", "fault"),
    [
        (LONG, f"{len(LONG.split())} words"),
        ("If it fails, it says so.", "'says so'"),
        ("The tree is built anew.", "'anew'"),
    ],
)
def test_a_fault_of_a_sentence_is_found(paragraph, fault):
    assert [fault in found for found in faults(paragraph)] == [True]


def test_a_summary_names_its_subject_and_is_short():
    assert "begins with 'What'" in faults("What was typed.", is_docstring=True)[0]
    assert "words" in faults(" ".join(["word"] * 21) + ".", is_docstring=True)[0]
    assert faults(" ".join(["word"] * 21) + ".") == []


def test_code_formulas_tables_and_quotations_are_not_prose():
    text = '"""Compute a sum.\n\n    a = b + c + d\n\nExample:\n    >>> sum([1, 2])\n    3\n"""\n'
    assert [piece.paragraphs[0] for piece in docstrings_of(text)] == ["Compute a sum."]
    page = "# Title\n\nA `name` and $x$.\n\n```python\nanew = 1\n```\n\n| anew | b |\n|---|---|\n| c | d |\n"
    assert [part for _, part in paragraphs_of(page)] == ["Title", "A X and $x$."]
    assert faults(f'He wrote "{LONG}" about it.') == []


def test_proselint_is_asked():
    CheckRegistry().register_many(english.__register__)
    config = Config(max_errors=10, checks=dict.fromkeys(english.PROSELINT, True))
    assert any("lexical" in fault for fault in general_faults(Piece(1, ["It is the the table."], is_docstring=False), config))
    assert list(general_faults(Piece(1, ["The product J J of two matrices."], is_docstring=False), config)) == []
