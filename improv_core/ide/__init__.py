"""Editor features, one per file, named after LSP's methods: pure functions of an analysis and an offset.

It knows no LSP and may import `program` and what that rests on. Begin with `hover`.
"""
