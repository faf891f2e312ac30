"""Measuring: the clock, the arms, the targets and the protocols of ``ulna bench`` and ``make bench``.

Only Ulna is timed here. The peers stand in ``benchmarks/``, beside the package, and are judged by the same protocols.
"""
