"""Makes machine code of formulas, and finds it by name. Used by everything that computes. The only package that knows Numba.

========================== ==========================================================================================
``entries``                entries by name: what callers ask for, whoever provides the machine code
``threads, processors``    large batches in parts, and how many processors this process may use
``lanes, width``           the operations of the number that may be eight numbers, as NumPy; how many it holds
``lane_types``             the same for the compiler: the type ``f64x8``,
``lane_lowering``          its operations,
``lane_operators``         and its operators
``decorators, signatures`` marks kernels and entries for the compiler; the types of entries' arguments
``cache, sources``         machine code on disk, found by a hash of the sources that it was compiled from
``warmup``                 compiles all entries ahead
``register_width``         which vector registers the compiled code uses
========================== ==========================================================================================

Only ``entries``, ``threads``, ``processors``, ``lanes``, ``width`` and ``sources`` may be imported without loading the compiler.
"""
