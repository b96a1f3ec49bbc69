"""The fast implementations of the definitions: one arithmetic (core.h), two loops."""
