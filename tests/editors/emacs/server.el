;;; server.el --- A server that comes late, and one that is killed: what a person asks for is done all the same  -*- lexical-binding: t; -*-

;; In the end, the program plays until Emacs itself is killed.

;;; Code:

(load (expand-file-name "steps" (file-name-directory load-file-name)) nil t)

(defconst gate (getenv "IMPROV_GATE") "The server starts only once this file is there.")

(setq improv-server-command (list (getenv "IMPROV_SLOW"))
      eglot-sync-connect nil
      eglot-autoreconnect t) ; however short the time was that a server has run

(defun while-the-server-starts (&rest commands)
  "Open the program, call COMMANDS, and see that a message says what happens then."
  (when (file-exists-p gate) (delete-file gate))
  (setq init-messages nil init-page nil)
  (find-file (getenv "IMPROV_PROGRAM"))
  (run-hooks 'post-command-hook)
  (check (not (eglot-managed-p)))
  (dolist (command commands)
    (set-buffer-modified-p t)
    (call-interactively command))
  (await "notice" (told "Improv is starting")))

(defun open-the-gate ()
  "Let the server start."
  (write-region "" nil gate)
  (await "server" (eglot-managed-p)))

(defun close-all ()
  "Close the program and end its server."
  (eglot-shutdown (eglot-current-server) nil 60)
  (set-buffer-modified-p nil)
  (kill-buffer))

(defun kill-server (told)
  "Kill the server as the system does, and wait until Eglot has TOLD that."
  (setq init-messages nil)
  (let ((process (jsonrpc--process (eglot-current-server))))
    (signal-process process 'KILL)
    (await "its death" (not (process-live-p process)))
    (delete-process process)) ; Emacs in batch knows of it, but at times calls no sentinel
  (await "the end" (told told)))

(defun save-again ()
  "Save what is saved already."
  (set-buffer-modified-p t)
  (save))

(while-the-server-starts #'improv-play)
(open-the-gate)
(await "playing" (told "▶ turtle1 ∞, endless at beat 120, simulator"))
(close-all)

(while-the-server-starts #'save-buffer #'improv-play #'improv-stop)
(open-the-gate)
(improv-seek "three")
(await "an answer" (told "improv.seek: expected a beat"))
(check (not (told "▶")))
(close-all)

(while-the-server-starts #'save-buffer)
(goto-char (point-max))
(insert "turtle1 $ (rig") ; half typed: what was saved plays
(open-the-gate)
(await "playing what was saved" (told "▶ turtle1 ∞, endless at beat 120, simulator"))
(await "a page" init-page)
(robot "moves")
(delete-region (progn (at "rig") (line-beginning-position)) (point-max))

;; A server that has run for a while is started again by Eglot.
(setq eglot-autoreconnect 600)
(kill-server "Reconnecting after unexpected server exit")
(await "the next one" (eglot-managed-p))
(await "nothing left of it" (null (left-behind)))
(save-again)
(await "playing again" (told "▶ turtle1 ∞"))

;; One that has just started is not; a save starts it.
(kill-server "Not auto-reconnecting")
(check (not (eglot-managed-p)))
(setq init-page nil)
(save-again)
(check (told "Improv is starting; then this program plays"))
(goto-char (point-max))
(insert "turtle1 $ (rig")
(run-hooks 'post-command-hook)
(await "playing once more" (told "▶ turtle1 ∞"))
(await "its page" init-page)
(princ (format "page: %s\n" init-page))
(flush-standard-output)
(while t (accept-process-output nil 1))

;;; server.el ends here
