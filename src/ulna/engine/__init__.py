"""Makes machine code of formulas. The only package that knows Numba.

========================== ==========================================================================================
``entries``                the functions that callers import, whoever provides their machine code
``threads, processors``    large batches in parts, and what this process may compute with
``lanes``                  the operations of the number that may be eight numbers, as NumPy; how many it holds
``ahead``                  machine code that a wheel brings, for the CPU at hand
``bound``                  functions of one q in C, by the wheel's extension
``decorators, signatures`` marks kernels and entries for the compiler; the types of entries' arguments
``compiler``               hands them to Numba, while Ctrl-C waits,
``numba_private``          by the private names listed here, or without those that are missing,
``trial``                  which is tried with a version of Numba that was not tested;
``pipelines``              runs the passes that they need, and makes no machine code of what is only copied,
``shared``                 and makes machine code of what is shared once
``lane_types``             the lanes for the compiler: the type ``f64x8`` and its operators,
``lane_lowering``          its operations,
``lane_rows``              its arrays, and how columns of a batch are loaded and stored
``cache, sources``         machine code on disk, found by a hash of the sources that it was compiled from
``native``                 a plain C interface for compiled entries, called by the extension in this process,
``emit``                   or written to object files for a wheel
``warmup``                 compiles all entries before they are called
========================== ==========================================================================================

Only those in the first five lines, ``signatures`` and ``sources`` may be imported without loading the compiler. ``decorators``
can be imported without Numba: then a kernel is the Python function itself.
"""
