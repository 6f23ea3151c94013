"""The declarations of families, one module each.

Each module offers `env`, `raw_env` and `parallel_env`, as PettingZoo's modules do.
"""
