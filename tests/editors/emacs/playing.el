;;; playing.el --- Has a program play, says where, and goes on until it is killed  -*- lexical-binding: t; -*-

;;; Code:

(load (expand-file-name "steps" (file-name-directory load-file-name)) nil t)

(open-program)
(improv-play)
(await "page" init-page)
(princ (format "page: %s\n" init-page))
(flush-standard-output)
(while t (accept-process-output nil 1))

;;; playing.el ends here
