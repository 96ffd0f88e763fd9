# Prints a page with its tables replaced: what stands between `<!-- table NAME -->` and `<!-- end of table -->` becomes
# the file FOLDER/NAME.md.
/^<!-- end of table -->$/ { inside = 0 }
!inside { print }
/^<!-- table [a-z0-9-]+ -->$/ {
  file = folder "/" $3 ".md"
  print ""
  found = 0
  while ((getline line < file) > 0) { print line; found = 1 }
  close(file)
  if (!found) { print FILENAME ": there is no " file > "/dev/stderr"; exit 1 }
  print ""
  inside = 1
}
