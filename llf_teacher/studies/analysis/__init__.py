"""What episodes of a store show: outcomes, their statistics, and comparisons."""
