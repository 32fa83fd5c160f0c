/* HDF5, as Debian builds it, can read files from Amazon's S3, for which it is linked with libcurl and libcrypto, and
   they with thirty libraries more. mimbre never reads such files: a wheel has this library in the place of those two
   (scripts/wheel). Its functions fail. no_network.map has the versions that HDF5 asks of them. */

enum { failed = 2 }; /* CURLE_FAILED_INIT */

void *curl_easy_init(void) { return 0; }
void curl_easy_cleanup(void *handle) { (void)handle; }
int curl_easy_perform(void *handle) { return (void)handle, failed; }
int curl_easy_setopt(void *handle, int option, ...) { return (void)handle, (void)option, failed; }
int curl_global_init(long flags) { return (void)flags, failed; }
void curl_global_cleanup(void) {}
void *curl_slist_append(void *list, const char *text) { return (void)list, (void)text, (void *)0; }
void curl_slist_free_all(void *list) { (void)list; }

const void *EVP_sha256(void) { return 0; }
unsigned char *HMAC(void) { return 0; }
unsigned char *SHA256(void) { return 0; }
