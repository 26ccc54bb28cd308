"""The language server: all of LSP, and nothing else."""
