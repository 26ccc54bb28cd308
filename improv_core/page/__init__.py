"""The page that shows robots move: its server, and in `static/` all that the browser loads.

It may import `preview`, `protocol`, `ide`, and what these rest on. Begin with `server`, then `routes`; in the browser,
with `static/page.js`.
"""
