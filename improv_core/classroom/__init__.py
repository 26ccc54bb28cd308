"""A class: children write dances in their own browsers and send them to the teacher, who plays them."""
