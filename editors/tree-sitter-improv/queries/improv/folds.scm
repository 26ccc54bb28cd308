[
  (definition)
  (play)
  (group)
  (squeeze)
  (comment)+
] @fold
