"""Feedback studies: a study is a frozen value; running, storing, statistics and reporting are separate modules."""
