"""The meaning of programs: from trees to an analysis, and from there to a score.

It may import `robots`, `syntax`, `score`, and what these rest on. Begin with `analysis`, then `meaning`; `compiler`
makes the score.
"""
