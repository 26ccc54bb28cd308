;;; improv-playing.el --- Highlight the words that are playing, and show the beat  -*- lexical-binding: t; -*-

;; Copyright (c) 2026 The Improv authors
;; SPDX-License-Identifier: MIT

;;; Commentary:

;; The language server says which words are lit and which beat it is whenever that changes: see docs/protocol.md.

;;; Code:

(require 'browse-url)
(require 'cl-lib)
(require 'eglot)
(require 'pulse)

(defgroup improv nil
  "Live coding for robot motion."
  :group 'languages)

(defface improv-playing
  '((t :inherit highlight))
  "Face for the words that are playing.")

(defcustom improv-highlight-playing t
  "Whether to highlight the words that are playing.
This takes effect when other words play."
  :type 'boolean)

(defclass improv-eglot-server (eglot-lsp-server)
  ((transport :initform nil :documentation "The state of playback, as last reported.")
   (lit :initform nil :documentation "The overlays on the words that are lit.")
   (versions :initform nil :documentation "The versions of the texts that the server has, by URI."))
  :documentation "The language server, and what it reports about playback.")

(defvar improv-playing--servers nil
  "The language servers that were started.")

(defvar improv-playing--starting nil
  "The language servers that were started and have not answered yet.")

(defvar-local improv-playing--waits nil
  "What is to play once the server has started.
The arguments of `improv.play', or a string: the text that was saved.")

(defvar-local improv-playing--served nil
  "Whether this buffer has had a server.")

(defun improv-playing--launched (server)
  "Remember that SERVER is starting."
  (when (improv-eglot-server-p server)
    (push server improv-playing--starting)))

(defun improv-playing--connected (server)
  "Remember SERVER, so that `improv-stop' reaches it from every buffer."
  (setq improv-playing--starting (delq server improv-playing--starting))
  (when (improv-eglot-server-p server)
    (push server improv-playing--servers)))

(add-hook 'eglot-server-initialized-hook #'improv-playing--launched)
(add-hook 'eglot-connect-hook #'improv-playing--connected)

;;; Messages from the server

(cl-defmethod eglot-client-capabilities ((_server improv-eglot-server))
  "Add to Eglot's capabilities, to get the messages about playback."
  (let ((capabilities (cl-call-next-method)))
    (plist-put capabilities :experimental '(:improv t))
    (plist-put capabilities :window `( :showDocument (:support ,(if (improv-playing--browses-p) t :json-false))
                                       :workDoneProgress :json-false))))

(defun improv-playing--browses-p ()
  "Return whether a browser can show the page.
Without a display, only one that the person has chosen can."
  (or (display-graphic-p) (getenv "DISPLAY") (getenv "WAYLAND_DISPLAY")
      (memq system-type '(darwin windows-nt))
      (not (eq browse-url-browser-function #'browse-url-default-browser))))

(cl-defmethod eglot-handle-notification
  ((_server improv-eglot-server) (_method (eql window/showMessage)) &key type message &allow-other-keys)
  "Show MESSAGE unchanged, in the color of its TYPE."
  (message "%s" (propertize message 'face (pcase type (1 'error) (2 'warning) (_ 'default)))))

(cl-defmethod jsonrpc-connection-send :before
  ((server improv-eglot-server) &rest sent)
  "Keep which version of a text SERVER gets, if it is SENT one."
  (when (memq (plist-get sent :method)
              '(:textDocument/didOpen :textDocument/didChange))
    (let* ((document (plist-get (plist-get sent :params) :textDocument))
           (uri (plist-get document :uri)))
      (setf (alist-get uri (slot-value server 'versions) nil nil #'equal)
            (plist-get document :version)))))

(cl-defmethod eglot-handle-notification
  ((server improv-eglot-server) (_method (eql improv/lit)) &rest told)
  "Highlight the words that SERVER has TOLD us, and no others.
Until SERVER has what was typed since, highlights move with the text."
  (let* ((uri (plist-get told :uri))
         (ranges (plist-get told :ranges))
         (buffer (improv-playing--buffer server uri)))
    (when (or (seq-empty-p ranges) (null buffer)
              (improv-playing--current-p server buffer told))
      (improv-playing--darken server)
      (when (and buffer improv-highlight-playing)
        (with-current-buffer buffer
          (setf (slot-value server 'lit)
                (mapcar #'improv-playing--overlay ranges)))))))

(cl-defmethod eglot-handle-notification
  ((server improv-eglot-server) (_method (eql improv/evaluated)) &rest told)
  "Flash what SERVER has TOLD us was just played."
  (when-let* ((buffer (improv-playing--buffer server (plist-get told :uri)))
              ((improv-playing--current-p server buffer told)))
    (with-current-buffer buffer
      (pcase-let ((`(,start . ,end) (improv-playing--region (plist-get told :range))))
        (pulse-momentary-highlight-region start end)))))

(cl-defmethod eglot-handle-notification
  ((server improv-eglot-server) (_method (eql improv/transport)) &rest told)
  "Keep the state of playback that SERVER has TOLD us, and show it."
  (setf (slot-value server 'transport) told)
  (dolist (buffer (improv-playing--buffers server))
    (with-current-buffer buffer (force-mode-line-update))))

(defun improv-playing--current-p (server buffer told)
  "Return whether what SERVER has TOLD us is about the text in BUFFER."
  (with-current-buffer buffer
    (and (jsonrpc-connection-ready-p server 'improv/lit) ; it has all that was typed
         (equal (plist-get told :version)
                (alist-get (plist-get told :uri) (slot-value server 'versions)
                           nil nil #'equal)))))

(defun improv-playing--region (range)
  "Return the start and the end of a RANGE of lines and columns."
  (pcase-let ((`[,line ,column ,end-line ,end-column] range))
    (eglot-range-region `( :start (:line ,line :character ,column)
                           :end (:line ,end-line :character ,end-column)))))

(defun improv-playing--overlay (range)
  "Highlight a RANGE of lines and columns, and return its overlay."
  (pcase-let* ((`(,start . ,end) (improv-playing--region range))
               (overlay (make-overlay start end nil t)))
    (overlay-put overlay 'improv-playing t)
    (overlay-put overlay 'face 'improv-playing)
    (overlay-put overlay 'evaporate t) ; a deleted word is not highlighted
    (overlay-put overlay 'priority 100)
    overlay))


;;; What is visible

(defun improv-playing-status ()
  "Return the state of playback for the mode line, or nil.
Beats count from 1."
  (when-let* ((server (improv-playing-server))
              (told (slot-value server 'transport))
              (state (plist-get told :state)))
    (pcase state
      ((or "playing" "paused")
       (let ((silenced (plist-get told :silenced)))
         (format " %s %s, %g beats/min, %s%s" (if (equal state "playing") "▶" "‖")
                 (plist-get told :counted) (plist-get told :tempo) (plist-get told :backend)
                 (if (string-empty-p silenced) "" (concat ", " silenced)))))
      ("waiting" (format " … waiting for robots, %s" (plist-get told :backend)))
      (_ (concat " ■ " state)))))

(defun improv-playing-server ()
  "Return the language server of this buffer, or nil."
  (let ((server (and (eglot-managed-p) (eglot-current-server))))
    (and (improv-eglot-server-p server) server)))

(defun improv-playing-wait (what)
  "Have WHAT of this program play as soon as its server has started.
WHAT is as in `improv-playing--waits'.  A server that was lost starts again.
Return nil if no server starts."
  (setq improv-playing--starting (cl-remove-if-not #'jsonrpc-running-p improv-playing--starting))
  (when (and (not (eglot-managed-p)) (or improv-playing--starting improv-playing--served))
    (unless improv-playing--starting
      (eglot-ensure))
    (message "Improv is starting; then this program plays")
    (setq improv-playing--waits what)))

(defun improv-playing-saved ()
  "Have what was just saved play if no server heard of the save."
  (unless (and (consp eglot-workspace-configuration)
               (equal (plist-get (plist-get eglot-workspace-configuration :improv) :onSave) "off"))
    (improv-playing-wait (save-restriction
                           (widen)
                           (buffer-substring-no-properties (point-min) (point-max))))))

(defun improv-playing-managed ()
  "Play what waits for the server, which has the program as it is now."
  (when-let* ((server (improv-playing-server)))
    (setq improv-playing--served t)
    (pcase (prog1 improv-playing--waits (setq improv-playing--waits nil))
      ('nil)
      ((and (pred stringp) text) ; what was saved is what plays, not what was typed since
       (jsonrpc-notify server :textDocument/didSave
                       (list :textDocument (list :uri (eglot-path-to-uri buffer-file-name)) :text text)))
      (arguments
       (jsonrpc-async-request server :workspace/executeCommand
                              (list :command "improv.play" :arguments (vconcat arguments)))))))

(defun improv-playing-forget ()
  "Play no program that waits for its server.  Return whether one did."
  (let (any)
    (dolist (buffer (buffer-list) any)
      (when (buffer-local-value 'improv-playing--waits buffer)
        (with-current-buffer buffer (setq improv-playing--waits nil any t))))))

(defun improv-playing-servers ()
  "Return all running language servers, even if their buffers are gone."
  (setq improv-playing--servers (cl-remove-if-not #'jsonrpc-running-p improv-playing--servers)))

(defun improv-playing-robots (server)
  "Return the names of the robots that SERVER plays."
  (append (plist-get (slot-value server 'transport) :robots) nil))

(defun improv-playing--buffers (server)
  "Return the buffers that SERVER manages."
  (cl-remove-if-not (lambda (buffer) (with-current-buffer buffer (eq (improv-playing-server) server))) (buffer-list)))

(defun improv-playing--buffer (server uri)
  "Return the buffer of the file at URI that SERVER manages, or nil."
  (cl-find-if (lambda (buffer) (equal uri (eglot-path-to-uri (buffer-file-name buffer))))
              (improv-playing--buffers server)))


;;; Cleanup

(defun improv-playing--darken (server)
  "Make the words of SERVER dark."
  (mapc #'delete-overlay (slot-value server 'lit))
  (setf (slot-value server 'lit) nil))

(defun improv-playing-leave ()
  "Remove all overlays from a buffer that no longer has a server."
  (unless (eglot-managed-p)
    (remove-overlays nil nil 'improv-playing t)
    (force-mode-line-update)))

(provide 'improv-playing)
;;; improv-playing.el ends here
