;;; improv-playing.el --- What plays: its words are lit, its beat is told  -*- lexical-binding: t; -*-

;; Copyright (c) 2026 The Improv authors
;; SPDX-License-Identifier: MIT

;;; Commentary:

;; The language server tells what is to come and a clock, not each event: docs/protocol.md.  Words are lit, and the mode
;; line moves on, by a timer that runs only while something plays.

;;; Code:

(require 'cl-lib)
(require 'eglot)

(defgroup improv nil
  "Live coding for robot motion."
  :group 'languages)

(defface improv-playing
  '((t :inherit highlight))
  "The words that play.")

(defcustom improv-highlight-playing t
  "Whether the words that play are lit, from the next beat on."
  :type 'boolean)

(defconst improv-playing--ahead 3
  "Seconds for which words are to be known; the server tells each second.")

(defconst improv-playing--shortest 0.02
  "Seconds between two looks: what is shorter than that, nobody sees.")

(defclass improv-eglot-server (eglot-lsp-server)
  ((transport :initform nil :documentation "Where it is, as last heard.")
   (heard :initform 0 :documentation "When that was, in seconds since 1970.")
   (words :initform nil :documentation "The words of each generation: they change hands when the stage says so.")
   (timer :initform nil :documentation "Runs only while something plays."))
  :documentation "The language server, and what it says about what plays.")

(defvar improv-playing--servers nil
  "The language servers that have been started.")

(defun improv-playing--connected (server)
  "Remember SERVER: its robots are to be stopped from wherever one is."
  (when (improv-eglot-server-p server)
    (push server improv-playing--servers)))

(add-hook 'eglot-connect-hook #'improv-playing--connected)

(cl-defstruct improv-playing--words
  "What a generation plays from a beat on: OVERLAYS in a buffer.
ROBOTS says when each has which of them; LIT are those that are lit."
  generation from robots overlays lit)


;;; What the server says

(cl-defmethod eglot-client-capabilities ((_server improv-eglot-server))
  "Those of Eglot; and what plays is lit here, its beat told here."
  (let ((capabilities (cl-call-next-method)))
    (plist-put capabilities :experimental '(:improv t))
    (plist-put capabilities :window '(:showDocument (:support t) :workDoneProgress :json-false))))

(cl-defmethod eglot-handle-notification
  ((_server improv-eglot-server) (_method (eql window/showMessage)) &key type message &allow-other-keys)
  "Show MESSAGE as it is, in the color of its TYPE."
  (message "%s" (propertize message 'face (pcase type (1 'error) (2 'warning) (_ 'default)))))

(cl-defmethod eglot-handle-notification
  ((server improv-eglot-server) (_method (eql improv/evaluated)) &key uri &allow-other-keys)
  "A program plays, or will soon: ask SERVER for the words of URI.
Those it has sent along may be of an older text than the buffer's."
  (improv-playing--ask server uri 0))

(cl-defmethod eglot-handle-notification
  ((server improv-eglot-server) (_method (eql improv/transport)) &rest told)
  "Keep what SERVER has TOLD about where it is, and show it."
  (setf (slot-value server 'transport) told
        ;; A message has been under way for at most a second, should the server's clock be another's.
        (slot-value server 'heard) (- (float-time) (min (max (- (float-time) (plist-get told :wall)) 0) 1)))
  (dolist (words (slot-value server 'words))
    (when (improv-playing--over-p (improv-playing--words-generation words) told)
      (improv-playing--drop server words)))
  (improv-playing--show server)
  (when (and (improv-playing--under-way-p told) (plist-get told :uri))
    (let* ((beat (improv-playing--beat server))
           (ahead (+ beat (/ (* improv-playing--ahead (plist-get told :tempo)) 60.0))))
      (unless (improv-playing--known-p (improv-playing--current server) beat ahead)
        (improv-playing--ask server (plist-get told :uri) beat)))))

(defun improv-playing--ask (server uri beat)
  "Have SERVER tell which words of URI play from BEAT on.
What does not fit the text as it is now is asked for again soon."
  (when-let* ((buffer (improv-playing--buffer server uri)))
    (with-current-buffer buffer
      (when (jsonrpc-connection-ready-p server :improv/moments) ; it has heard of all that was typed
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
  "Mark the words in BUFFER that SERVER has TOLD to play, FROM a beat on."
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
  "An overlay, not lit yet, on a RANGE of lines and columns."
  (pcase-let* ((`[,line ,column ,end-line ,end-column] range)
               (`(,start . ,end) (eglot-range-region
                                  `( :start (:line ,line :character ,column)
                                     :end (:line ,end-line :character ,end-column))))
               (overlay (make-overlay start end nil t)))
    (overlay-put overlay 'improv-playing t)
    (overlay-put overlay 'evaporate t) ; a word that is deleted is not lit
    (overlay-put overlay 'priority 100)
    overlay))


;;; What is seen of it

(defun improv-playing-status ()
  "What plays, in a few words for the mode line, or nil."
  (when-let* ((server (improv-playing-server))
              (told (slot-value server 'transport))
              (state (plist-get told :state)))
    (pcase state
      ((or "playing" "paused")
       (let ((last (and (plist-get told :beats) (max (ceiling (plist-get told :beats)) 1)))
             (beat (1+ (floor (improv-playing--beat server)))))
         (format " %s %d/%s %g bpm, %s" (if (equal state "playing") "▶" "‖")
                 (if last (min beat last) beat) (or last "∞") (plist-get told :tempo) (plist-get told :backend))))
      ("waiting" (format " … waits for robots, %s" (plist-get told :backend)))
      (_ (concat " ■ " state)))))

(defun improv-playing-server ()
  "The language server of this buffer, or nil."
  (let ((server (and (eglot-managed-p) (eglot-current-server))))
    (and (improv-eglot-server-p server) server)))

(defun improv-playing-servers ()
  "All language servers at work, also those whose buffers are gone."
  (setq improv-playing--servers (cl-remove-if-not #'jsonrpc-running-p improv-playing--servers)))

(defun improv-playing-robots (server)
  "The names of the robots that SERVER plays on."
  (delete-dups (cl-loop for words in (slot-value server 'words)
                        append (cl-loop for (robot) on (improv-playing--words-robots words) by #'cddr
                                        collect (substring (symbol-name robot) 1)))))

(defun improv-playing--show (server)
  "Show where SERVER is; once that is another place, come again."
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
  "Light those of WORDS that robots not silent by TOLD play at BEAT.
The value is the beat at which to come again, or nil."
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
  "Light the WORDS whose indices are WANTED, and no others."
  (let ((overlays (improv-playing--words-overlays words))
        (lit (improv-playing--words-lit words)))
    (dolist (index (cl-set-difference lit wanted))
      (overlay-put (aref overlays index) 'face nil))
    (dolist (index (cl-set-difference wanted lit))
      (overlay-put (aref overlays index) 'face 'improv-playing))
    (setf (improv-playing--words-lit words) wanted)))

(defun improv-playing--moment (moments beat)
  "The first of MOMENTS that ends after BEAT, which may be yet to come; or nil."
  (let ((low 0) (high (length moments)))
    (while (< low high)
      (let ((middle (/ (+ low high) 2)))
        (if (> (aref (aref moments middle) 1) beat)
            (setq high middle)
          (setq low (1+ middle)))))
    (and (< low (length moments)) (aref moments low))))

(defun improv-playing--silent-p (robot told)
  "Whether ROBOT is told to stand still while others play, by what was TOLD."
  (if (seq-empty-p (plist-get told :soloed))
      (seq-contains-p (plist-get told :muted) robot)
    (not (seq-contains-p (plist-get told :soloed) robot))))

(defun improv-playing--known-p (words beat ahead)
  "Whether WORDS say what plays from BEAT to AHEAD."
  (and words
       (<= (improv-playing--words-from words) beat)
       (cl-loop for (_robot stretch) on (improv-playing--words-robots words) by #'cddr
                for until = (plist-get stretch :until)
                never (and until (< until ahead)))))

(defun improv-playing--beat (server)
  "The beat that SERVER is at."
  (let* ((told (slot-value server 'transport))
         (passed (if (equal (plist-get told :state) "playing")
                     (/ (* (- (float-time) (slot-value server 'heard)) (plist-get told :tempo)) 60)
                   0))
         (beat (+ (or (plist-get told :beat) 0) passed)))
    (if (plist-get told :beats) (min beat (plist-get told :beats)) beat)))

(defun improv-playing--under-way-p (told)
  "Whether, by what was TOLD, something plays or is paused."
  (member (plist-get told :state) '("playing" "paused")))

(defun improv-playing--over-p (generation told)
  "Whether, by what was TOLD, a GENERATION plays no more, nor ever will."
  (and told
       (or (< generation (plist-get told :generation))
           (and (= generation (plist-get told :generation))
                (not (member (plist-get told :state) '("playing" "paused" "waiting")))))))

(defun improv-playing--current (server)
  "The words of what SERVER plays, or nil."
  (let ((told (slot-value server 'transport)))
    (and (improv-playing--under-way-p told)
         (improv-playing--of-generation server (plist-get told :generation)))))

(defun improv-playing--of-generation (server generation)
  "The words of a GENERATION that SERVER has told of, or nil."
  (cl-find generation (slot-value server 'words) :key #'improv-playing--words-generation))

(defun improv-playing--buffers (server)
  "The buffers that SERVER is at work in."
  (cl-remove-if-not (lambda (buffer) (with-current-buffer buffer (eq (improv-playing-server) server))) (buffer-list)))

(defun improv-playing--buffer (server uri)
  "The buffer of the file at URI, where SERVER is at work, or nil."
  (cl-find-if (lambda (buffer) (equal uri (eglot-path-to-uri (buffer-file-name buffer))))
              (improv-playing--buffers server)))


;;; What is left of it: nothing

(defun improv-playing--drop (server words)
  "Have SERVER forget WORDS, and leave none of them in their buffer."
  (setf (slot-value server 'words) (remq words (slot-value server 'words)))
  (mapc #'delete-overlay (improv-playing--words-overlays words)))

(defun improv-playing-leave ()
  "Leave nothing in a buffer that has no server any more."
  (unless (eglot-managed-p)
    (remove-overlays nil nil 'improv-playing t)
    (force-mode-line-update)))

(provide 'improv-playing)
;;; improv-playing.el ends here
