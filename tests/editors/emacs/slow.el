;;; slow.el --- Saves, plays, or stops while the server starts, which it does at the gate  -*- lexical-binding: t; -*-

;;; Code:

(load (expand-file-name "steps" (file-name-directory load-file-name)) nil t)

(setq improv-server-command (list (getenv "IMPROV_SLOW")) eglot-sync-connect nil)
(find-file (getenv "IMPROV_PROGRAM"))
(run-hooks 'post-command-hook)
(check (not (eglot-managed-p)))
(dolist (step (split-string (getenv "IMPROV_STEPS")))
  (set-buffer-modified-p t)
  (call-interactively (intern step)))
(await "notice" (told "Improv is starting"))
(write-region "" nil (getenv "IMPROV_GATE"))
(await "server" (eglot-managed-p))
(if (string-search "hush" (getenv "IMPROV_STEPS"))
    (progn
      (improv-seek "three")
      (await "an answer" (told "improv.seek: expected a beat"))
      (check (not (told "▶"))))
  (await "playing" (told "▶ turtle1 ∞, endless at beat 120, simulator"))
  (await "page" init-page)
  (robot "moves"))
(kill-emacs 0)

;;; slow.el ends here
