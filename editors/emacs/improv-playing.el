;;; improv-playing.el --- Highlight the words that are playing, and show the beat  -*- lexical-binding: t; -*-

;; Copyright (c) 2026 The Improv authors
;; SPDX-License-Identifier: MIT

;;; Commentary:

;; The language server reports what will play, and a clock, instead of each event: see docs/protocol.md.  A timer
;; highlights words and updates the mode line.  It runs only while something plays.

;;; Code:

(require 'cl-lib)
(require 'eglot)

(defgroup improv nil
  "Live coding for robot motion."
  :group 'languages)

(defface improv-playing
  '((t :inherit highlight))
  "Face for the words that are playing.")

(defcustom improv-highlight-playing t
  "Whether to highlight the words that are playing.
This takes effect at the next beat."
  :type 'boolean)

(defconst improv-playing--ahead 3
  "How many seconds ahead the words must be known.
The server reports its clock each second.")

(defconst improv-playing--shortest 0.02
  "The shortest time between two updates, in seconds; nobody sees a shorter one.")

(defclass improv-eglot-server (eglot-lsp-server)
  ((transport :initform nil :documentation "The state of playback, as last reported.")
   (heard :initform 0 :documentation "When it was reported, in seconds since 1970.")
   (words :initform nil :documentation "The words of each generation.  The next generation may already wait.")
   (timer :initform nil :documentation "It runs only while something plays."))
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
  "Remember SERVER, so that `improv-hush' reaches it from every buffer."
  (setq improv-playing--starting (delq server improv-playing--starting))
  (when (improv-eglot-server-p server)
    (push server improv-playing--servers)))

(add-hook 'eglot-server-initialized-hook #'improv-playing--launched)
(add-hook 'eglot-connect-hook #'improv-playing--connected)

(cl-defstruct improv-playing--words
  "The words of a generation: OVERLAYS in a buffer, known FROM a beat on.
ROBOTS holds which of them each robot performs when, by index.
LIT is the list of those that are highlighted."
  generation from robots overlays lit)


;;; Messages from the server

(cl-defmethod eglot-client-capabilities ((_server improv-eglot-server))
  "Add to Eglot's capabilities, to get the messages about playback."
  (let ((capabilities (cl-call-next-method)))
    (plist-put capabilities :experimental '(:improv t))
    (plist-put capabilities :window '(:showDocument (:support t) :workDoneProgress :json-false))))

(cl-defmethod eglot-handle-notification
  ((_server improv-eglot-server) (_method (eql window/showMessage)) &key type message &allow-other-keys)
  "Show MESSAGE unchanged, in the color of its TYPE."
  (message "%s" (propertize message 'face (pcase type (1 'error) (2 'warning) (_ 'default)))))

(cl-defmethod eglot-handle-notification
  ((server improv-eglot-server) (_method (eql improv/evaluated)) &key uri from &allow-other-keys)
  "A program has taken over at beat FROM: ask SERVER for the words of URI.
The words in the message may belong to an older text."
  (improv-playing--ask server uri from))

(cl-defmethod eglot-handle-notification
  ((server improv-eglot-server) (_method (eql improv/transport)) &rest told)
  "Keep the state of playback that SERVER has TOLD us, and show it."
  (setf (slot-value server 'transport) told
        ;; A message takes at most a second.  A larger difference means that the clocks differ.
        (slot-value server 'heard) (- (float-time) (min (max (- (float-time) (plist-get told :wall)) 0) 1)))
  (dolist (words (slot-value server 'words))
    (when (improv-playing--over-p (improv-playing--words-generation words) told)
      (improv-playing--drop server words)))
  (improv-playing--show server)
  (when (and (improv-playing--active-p told) (plist-get told :uri))
    (let* ((beat (improv-playing--beat server))
           (ahead (+ beat (/ (* improv-playing--ahead (plist-get told :tempo)) 60.0))))
      (unless (improv-playing--known-p (improv-playing--current server) beat ahead)
        (improv-playing--ask server (plist-get told :uri) beat)))))

(defun improv-playing--ask (server uri beat)
  "Ask SERVER which words of URI play from BEAT on.
If the text changes meanwhile, the answer is dropped; we ask again soon."
  (when-let* ((buffer (improv-playing--buffer server uri)))
    (with-current-buffer buffer
      (when (jsonrpc-connection-ready-p server :improv/moments) ; it knows everything that was typed
        (let ((tick (buffer-chars-modified-tick)))
          (jsonrpc-async-request
           server :improv/moments (list :beat beat)
           :success-fn (lambda (told)
                         (when (and (buffer-live-p buffer) (= tick (buffer-chars-modified-tick buffer))
                                    (equal uri (plist-get told :uri))
                                    (not (improv-playing--over-p (plist-get told :generation)
                                                                 (slot-value server 'transport))))
                           (improv-playing--take server buffer beat told)))))))))

(defun improv-playing--take (server buffer from told)
  "Mark the words in BUFFER that play FROM a beat on, as SERVER has TOLD us."
  (let* ((generation (plist-get told :generation))
         (old (improv-playing--of-generation server generation)))
    (when old
      (improv-playing--drop server old))
    (with-current-buffer buffer
      (push (make-improv-playing--words
             :generation generation :from from :robots (plist-get told :robots)
             :overlays (cl-map 'vector #'improv-playing--overlay (plist-get told :ranges)))
            (slot-value server 'words)))
    (improv-playing--show server)))

(defun improv-playing--overlay (range)
  "Return an overlay on a RANGE of lines and columns, not highlighted yet."
  (pcase-let* ((`[,line ,column ,end-line ,end-column] range)
               (`(,start . ,end) (eglot-range-region
                                  `( :start (:line ,line :character ,column)
                                     :end (:line ,end-line :character ,end-column))))
               (overlay (make-overlay start end nil t)))
    (overlay-put overlay 'improv-playing t)
    (overlay-put overlay 'evaporate t) ; a deleted word is not highlighted
    (overlay-put overlay 'priority 100)
    overlay))


;;; What is visible

(defun improv-playing-status ()
  "Return the state of playback for the mode line, or nil."
  (when-let* ((server (improv-playing-server))
              (told (slot-value server 'transport))
              (state (plist-get told :state)))
    (pcase state
      ((or "playing" "paused")
       (let ((last (and (plist-get told :beats) (max (ceiling (plist-get told :beats)) 1)))
             (beat (1+ (floor (improv-playing--beat server)))))
         (format " %s %d/%s %g bpm, %s" (if (equal state "playing") "▶" "‖")
                 (if last (min beat last) beat) (or last "∞") (plist-get told :tempo) (plist-get told :backend))))
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
  (delete-dups (cl-loop for words in (slot-value server 'words)
                        append (cl-loop for (robot) on (improv-playing--words-robots words) by #'cddr
                                        collect (substring (symbol-name robot) 1)))))

(defun improv-playing--show (server)
  "Show the state of playback of SERVER, and again at its next change."
  (when (slot-value server 'timer)
    (cancel-timer (slot-value server 'timer))
    (setf (slot-value server 'timer) nil))
  (when-let* ((buffers (and (jsonrpc-running-p server) (improv-playing--buffers server))))
    (let* ((told (slot-value server 'transport))
           (words (improv-playing--current server))
           (beat (improv-playing--beat server))
           (change (and words (improv-playing--light words beat told)))
           (next (min (or change most-positive-fixnum) (1+ (floor beat)))))
      (dolist (buffer buffers)
        (with-current-buffer buffer (force-mode-line-update)))
      (when (equal (plist-get told :state) "playing")
        (setf (slot-value server 'timer)
              (run-at-time (max (/ (* (- next beat) 60.0) (plist-get told :tempo)) improv-playing--shortest) nil
                           #'improv-playing--show server))))))

(defun improv-playing--light (words beat told)
  "Highlight those of WORDS that play at BEAT.
Leave out the robots that are muted according to TOLD.
Return the beat at which that changes, or nil."
  (let (wanted change)
    (cl-loop for (robot stretch) on (improv-playing--words-robots words) by #'cddr
             for moment = (improv-playing--moment (plist-get stretch :moments) beat)
             when moment do
             (pcase-let* ((`[,start ,end ,indices] moment)
                          (plays (<= start beat)))
               (setq change (min (or change most-positive-fixnum) (if plays end start)))
               (unless (or (not plays) (not improv-highlight-playing)
                           (improv-playing--silent-p (substring (symbol-name robot) 1) told))
                 (setq wanted (append indices wanted)))))
    (improv-playing--set-lit words (delete-dups wanted))
    change))

(defun improv-playing--set-lit (words wanted)
  "Highlight the WORDS whose indices are WANTED, and no others."
  (let ((overlays (improv-playing--words-overlays words))
        (lit (improv-playing--words-lit words)))
    (dolist (index (cl-set-difference lit wanted))
      (overlay-put (aref overlays index) 'face nil))
    (dolist (index (cl-set-difference wanted lit))
      (overlay-put (aref overlays index) 'face 'improv-playing))
    (setf (improv-playing--words-lit words) wanted)))

(defun improv-playing--moment (moments beat)
  "Return the first of MOMENTS that ends after BEAT, or nil.
It may not have begun."
  (let ((low 0) (high (length moments)))
    (while (< low high)
      (let ((middle (/ (+ low high) 2)))
        (if (> (aref (aref moments middle) 1) beat)
            (setq high middle)
          (setq low (1+ middle)))))
    (and (< low (length moments)) (aref moments low))))

(defun improv-playing--silent-p (robot told)
  "Return whether ROBOT stands still while others play, according to TOLD."
  (if (seq-empty-p (plist-get told :soloed))
      (seq-contains-p (plist-get told :muted) robot)
    (not (seq-contains-p (plist-get told :soloed) robot))))

(defun improv-playing--known-p (words beat ahead)
  "Return whether WORDS cover what plays from BEAT to AHEAD."
  (and words
       (<= (improv-playing--words-from words) beat)
       (cl-loop for (_robot stretch) on (improv-playing--words-robots words) by #'cddr
                for until = (plist-get stretch :until)
                never (and until (< until ahead)))))

(defun improv-playing--beat (server)
  "Return the current beat of SERVER."
  (let* ((told (slot-value server 'transport))
         (passed (if (equal (plist-get told :state) "playing")
                     (/ (* (- (float-time) (slot-value server 'heard)) (plist-get told :tempo)) 60)
                   0))
         (beat (+ (or (plist-get told :beat) 0) passed)))
    (if (plist-get told :beats) (min beat (plist-get told :beats)) beat)))

(defun improv-playing--active-p (told)
  "Return whether something plays or is paused, according to TOLD."
  (member (plist-get told :state) '("playing" "paused")))

(defun improv-playing--over-p (generation told)
  "Return whether GENERATION has ended for good, according to TOLD."
  (and told
       (or (< generation (plist-get told :generation))
           (and (= generation (plist-get told :generation))
                (not (member (plist-get told :state) '("playing" "paused" "waiting")))))))

(defun improv-playing--current (server)
  "Return the words that SERVER plays now, or nil."
  (let ((told (slot-value server 'transport)))
    (and (improv-playing--active-p told)
         (improv-playing--of-generation server (plist-get told :generation)))))

(defun improv-playing--of-generation (server generation)
  "Return the words of GENERATION that SERVER reported, or nil."
  (cl-find generation (slot-value server 'words) :key #'improv-playing--words-generation))

(defun improv-playing--buffers (server)
  "Return the buffers that SERVER manages."
  (cl-remove-if-not (lambda (buffer) (with-current-buffer buffer (eq (improv-playing-server) server))) (buffer-list)))

(defun improv-playing--buffer (server uri)
  "Return the buffer of the file at URI that SERVER manages, or nil."
  (cl-find-if (lambda (buffer) (equal uri (eglot-path-to-uri (buffer-file-name buffer))))
              (improv-playing--buffers server)))


;;; Cleanup

(defun improv-playing--drop (server words)
  "Remove WORDS from SERVER and from their buffer."
  (setf (slot-value server 'words) (remq words (slot-value server 'words)))
  (mapc #'delete-overlay (improv-playing--words-overlays words)))

(defun improv-playing-leave ()
  "Remove all overlays from a buffer that no longer has a server."
  (unless (eglot-managed-p)
    (remove-overlays nil nil 'improv-playing t)
    (force-mode-line-update)))

(provide 'improv-playing)
;;; improv-playing.el ends here
