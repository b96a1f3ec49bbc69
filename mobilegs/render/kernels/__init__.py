"""Launch the kernels in mobilegs/csrc: the CPU's by ctypes, CUDA's by the driver."""
