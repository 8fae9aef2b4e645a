"""Compiled kernels: the one home of numba.

Kernels take checked arrays and neither validate nor allocate inside their loops; the
public functions of the rooms above validate once and speak numpy.
"""
