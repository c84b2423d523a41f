"""Known methods on the first 30 fixed concealed cases, beside `autodb explain`: see README.md.

``cases`` writes a case without its truth, ``answer`` lets one method answer it in a process of its
own, ``score`` compares with the truth, ``run`` does all of them, ``table`` sums up.
"""
