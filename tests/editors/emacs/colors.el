;;; colors.el --- Prints each word of the program and its face, as JSON  -*- lexical-binding: t; -*-

;;; Code:

(require 'json)

(with-temp-buffer
  (insert-file-contents (getenv "IMPROV_PROGRAM"))
  (improv-mode)
  (font-lock-ensure)
  (let (found)
    (while (re-search-forward "[^ \n]+" nil t)
      (push (vector (match-string 0) (symbol-name (get-text-property (match-beginning 0) 'face))) found))
    (princ (json-encode (vconcat (nreverse found))))))

;;; colors.el ends here
