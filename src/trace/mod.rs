//! Tracing kernels, one file each, and the probes that count their work.
