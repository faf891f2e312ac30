"""Drivers for a GPU, one problem a thread. Used by ``robot.gpu_robot``.

They run the same kernels as the drivers beside this folder; here the number is a float64. Scratch is in local memory, whose size
the compiler must know: a driver that needs some is made for the size of a robot, and kept.
"""
