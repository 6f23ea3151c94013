"""Thermostat: a family of environments that is installed on its own."""
