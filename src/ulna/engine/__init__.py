"""Makes machine code of formulas. The only package that knows Numba.

========================== ==========================================================================================
``entries``                the functions that callers import, whoever provides their machine code
``threads, processors``    large batches in parts, and how many processors this process may use
``lanes, width``           the operations of the number that may be eight numbers, as NumPy; how many it holds
``ahead``                  machine code that a wheel brings, for the CPU at hand
``bound``                  functions of one q in C, by the wheel's extension
``decorators, signatures`` marks kernels and entries for the compiler; the types of entries' arguments
``compiler``               hands them to Numba,
``pipelines``              which runs the passes that they need,
``without_code``           makes no machine code of what is only copied, aligns the stack of what is compiled,
``shared``                 and makes machine code of what is shared once
``interrupts``             Ctrl-C waits until the compiler is done
``lane_types``             the lanes for the compiler: the type ``f64x8``,
``lane_lowering``          its operations,
``lane_operators``         its operators,
``lane_rows``              its arrays, and how columns of a batch are loaded and stored
``cache, sources``         machine code on disk, found by a hash of the sources that it was compiled from
``plain``                  a plain C interface for compiled entries,
``emit``                   which are written to object files for a wheel,
``native``                 or given to the extension in this process
``warmup``                 compiles all entries before they are called
``register_width``         which vector registers the compiled code uses
========================== ==========================================================================================

Only those in the first five lines, ``signatures`` and ``sources`` may be imported without loading the compiler. ``decorators``
can be imported without Numba: then a kernel is the Python function itself.
"""
