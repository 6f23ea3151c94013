"""`python -m llf_teacher` is `llf`."""

from llf_teacher.cli import main

main()
