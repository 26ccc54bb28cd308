;;; robots.el --- A person's session in an improv.toml with a misspelled profile  -*- lexical-binding: t; -*-

;;; Code:

(load (expand-file-name "steps" (file-name-directory load-file-name)) nil t)

(open-program)
(dolist (name '("improv.toml" "other.toml"))
  (write-region "[robots.turtle1]\nprofile = \"turtlebot3_burgr\"\n\n" nil (expand-file-name name default-directory)))
(let ((server (eglot-current-server)))
  (find-file (expand-file-name "improv.toml" default-directory))
  (check (derived-mode-p 'improv-robots-mode))
  (run-hooks 'post-command-hook)
  (await "server" (eglot-managed-p))
  (check (eq server (eglot-current-server))))
(await "diagnostic"
  (pcase (problems) (`((,_ . ,text)) (string-search "did you mean `turtlebot3_burger`?" text))))
;; Eglot completes symbols.
(with-temp-buffer
  (insert "[robots.turt")
  (with-syntax-table improv-robots-mode-syntax-table (check (equal (thing-at-point 'symbol t) "turt")))
  (insert " 1.5")
  (with-syntax-table improv-mode-syntax-table (check (equal (thing-at-point 'symbol t) "1.5"))))
(find-file (expand-file-name "other.toml" default-directory))
(check (not (derived-mode-p 'improv-robots-mode)))

;;; robots.el ends here
