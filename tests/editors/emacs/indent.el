;;; indent.el --- Indents what is on standard input, line by line  -*- lexical-binding: t; -*-

;;; Code:

(with-temp-buffer
  (condition-case nil
      (while t (insert (read-from-minibuffer "") "\n"))
    (end-of-file))
  (improv-mode)
  (let ((inhibit-message t))
    (indent-region (point-min) (point-max)))
  (princ (buffer-string)))

;;; indent.el ends here
