"""A class: children write dances in their own browsers and send them to the teacher, who plays them.

Only `commands` imports it. Begin with `desk`, the teacher's side; `student_server` serves the children in a process of
its own and keeps what they send (`kept`), and `checker` reads their dances in another.
"""
