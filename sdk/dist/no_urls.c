/* SPDX-License-Identifier: Apache-2.0 */
/* NetCDF and HDF5 read URLs as well as files, with curl, OpenSSL and libxml2: 45 MB of libraries, which a package that
   carries them would have to keep safe. Binnacle opens files only. These are the functions that both call for URLs; each
   fails in the way that its documentation gives. sdk/dist/carry builds them in place of those libraries. */
#include <stddef.h>

/* curl: its start succeeds, as it does at every load of NetCDF; no transfer can be made. */
int curl_global_init(long flags) { (void)flags; return 0; }
void curl_global_cleanup(void) {}
void *curl_easy_init(void) { return NULL; }
void curl_easy_cleanup(void *handle) { (void)handle; }
int curl_easy_getinfo(void *handle, int what, ...) { (void)handle, (void)what; return 43; } /* CURLE_BAD_FUNCTION_ARGUMENT */
int curl_easy_perform(void *handle) { (void)handle; return 43; }
int curl_easy_setopt(void *handle, int option, ...) { (void)handle, (void)option; return 43; }
const char *curl_easy_strerror(int code) { (void)code; return "URLs are not supported"; }
void *curl_slist_append(void *list, const char *text) { (void)list, (void)text; return NULL; }
void curl_slist_free_all(void *list) { (void)list; }

/* The first members of curl_version_info_data: a curl without protocols. */
struct version_info {
  int age;
  const char *version;
  unsigned version_number;
  const char *host;
  int features;
  const char *ssl_version;
  long ssl_version_number;
  const char *zlib_version;
  const char *const *protocols;
  void *later[24];
};
static const char *const no_protocols[] = {NULL};
static const struct version_info info = {0, "0", 0, "", 0, NULL, 0, NULL, no_protocols, {NULL}};
const void *curl_version_info(int age) { (void)age; return &info; }

/* OpenSSL: the signatures of requests to S3. */
const void *EVP_sha256(void) { return NULL; }
unsigned char *HMAC(const void *method, const void *key, int size, const unsigned char *text, size_t length,
                    unsigned char *digest, unsigned *digest_size) {
  (void)method, (void)key, (void)size, (void)text, (void)length, (void)digest, (void)digest_size;
  return NULL;
}
unsigned char *SHA256(const unsigned char *text, size_t length, unsigned char *digest) {
  (void)text, (void)length, (void)digest;
  return NULL;
}

/* libxml2: the answers of DAP servers; none can be parsed. */
void *xmlReadMemory(const char *text, int size, const char *url, const char *encoding, int options) {
  (void)text, (void)size, (void)url, (void)encoding, (void)options;
  return NULL;
}
void *xmlDocGetRootElement(const void *document) { (void)document; return NULL; }
unsigned char *xmlGetProp(const void *node, const unsigned char *name) { (void)node, (void)name; return NULL; }
unsigned char *xmlNodeGetContent(const void *node) { (void)node; return NULL; }
unsigned char *xmlNodeListGetString(void *document, const void *list, int in_line) {
  (void)document, (void)list, (void)in_line;
  return NULL;
}
void xmlFreeDoc(void *document) { (void)document; }
void xmlCleanupParser(void) {}
static void free_nothing(void *block) { (void)block; }
void (*xmlFree)(void *) = free_nothing;
