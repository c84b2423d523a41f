"""The physics of every channel: one term is one effect with named parameters.

A new one is a function and its term: listed in
``autodb.terms.vocabulary``, or of another package.
"""
