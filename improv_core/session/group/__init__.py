"""Several stages that play as one, on this machine and on others.

Begin with `state`, then `rules`, which decide; `multi_host_stage` carries out their decisions.
"""
