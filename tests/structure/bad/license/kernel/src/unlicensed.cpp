// A file without a licence. // bad
int a;
