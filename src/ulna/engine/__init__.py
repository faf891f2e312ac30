"""Compiles formulas to machine code. The only package that knows Numba.

========================== ==========================================================================================
``entries``                the functions that callers import, from a wheel or compiled by Numba.
``threads, processors``    large batches in parts, and the processors of this process.
``lanes``                  operations on a number or on eight numbers, in NumPy; the number of lanes.
``ahead``                  machine code of a wheel, for the CPU at hand.
``bound``                  functions of one q in C, by the wheel's extension.
``decorators, signatures`` mark kernels and entries for the compiler; the types of entries' arguments.
``compiler``               passes them to Numba, and defers Ctrl-C.
``numba_private``          lists Numba's private names, and detects missing ones.
``trial``                  tests the engine with an untested version of Numba.
``pipelines``              selects Numba's passes, and skips machine code for inlined functions.
``shared``                 compiles shared routines once.
``lane_types``             the lanes for the compiler: the type ``f64x8`` and its operators.
``lane_lowering``          their operations.
``lane_rows``              their arrays, and loads and stores of a batch's columns.
``cache, sources``         machine code on disk, found by a hash of its source files.
``second_process, fill``   compile the longest entries beside a program that compiles.
``child_program``          programs for another Python, isolated from the user's files.
``native``                 a plain C interface for compiled entries, called by the extension in this process.
``emit``                   writes entries to object files for a wheel.
``warmup``                 compiles all entries before they are called.
========================== ==========================================================================================

Only the modules in the first five lines, ``signatures`` and ``sources`` may be imported without loading the compiler.
``decorators`` can be imported without Numba: then a kernel is the Python function itself.
"""
