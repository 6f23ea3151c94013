"""The analysis of stored episodes: outcomes, their statistics, and comparisons."""
