"""Where models are trained and judged: each module speaks to one framework, which is an extra of the same name."""
