/* mesh_file.c: a file is PLY by its name or its first bytes. Everything else goes to assimp, which
 * is optional: a build without it says what to install. */
#include "mesh_file.h"

#include "ply.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#ifdef HAVE_ASSIMP

/* Headers of others are not held to our warnings. */
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wc++-compat"
#pragma GCC diagnostic ignored "-Wconversion"
#endif
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

static bool reserve_scene(const struct aiScene *scene, shape *out) {
    uint64_t vertices = 0, faces = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
        vertices += scene->mMeshes[i]->mNumVertices;
        faces += scene->mMeshes[i]->mNumFaces;
    }
    if (vertices > UINT32_MAX || faces > UINT32_MAX) return false;
    out->positions = (float *)malloc((size_t)(vertices + 1) * 12);
    out->indices = (uint32_t *)malloc((size_t)(faces + 1) * 12);
    return out->positions && out->indices;
}

/* Appends one mesh; points and lines, which assimp keeps as faces of one and two corners, are left.
 */
static void append_mesh(const struct aiMesh *mesh, shape *out) {
    const uint32_t first = (uint32_t)out->vertex_count;
    for (unsigned i = 0; i < mesh->mNumVertices; ++i) {
        float *p = out->positions + 3 * out->vertex_count++;
        p[0] = (float)mesh->mVertices[i].x;
        p[1] = (float)mesh->mVertices[i].y;
        p[2] = (float)mesh->mVertices[i].z;
    }
    for (unsigned i = 0; i < mesh->mNumFaces; ++i) {
        const struct aiFace *face = &mesh->mFaces[i];
        if (face->mNumIndices != 3) continue;
        uint32_t *t = out->indices + 3 * out->triangle_count++;
        for (int k = 0; k < 3; ++k) t[k] = first + face->mIndices[k];
    }
}

static bool read_by_assimp(const char *path, shape *out, char *error, size_t size) {
    /* PreTransformVertices applies the node tree, so that instances stand where they belong. */
    const struct aiScene *scene =
        aiImportFile(path, aiProcess_Triangulate | aiProcess_PreTransformVertices);
    if (!scene) {
        const char *text = aiGetErrorString();
        size_t length = strcspn(text, "\r\n");
        if (length && text[length - 1] == '.') --length;
        snprintf(error, size, "%s: %.*s; give a mesh as PLY, OBJ, STL, glTF, ...", path,
                 (int)length, text);
        return false;
    }
    const bool ok = reserve_scene(scene, out);
    for (unsigned i = 0; ok && i < scene->mNumMeshes; ++i) append_mesh(scene->mMeshes[i], out);
    aiReleaseImport(scene);
    if (!ok) snprintf(error, size, "%s: out of memory, or more than 2^32 vertices", path);
    return ok;
}

#else

static bool read_by_assimp(const char *path, shape *out, char *error, size_t size) {
    (void)out;
    snprintf(error, size,
             "%s: this build reads PLY only; for other formats install assimp "
             "(apt-get install libassimp-dev) and build again",
             path);
    return false;
}

#endif

static bool is_ply(const char *path, const char *head) {
    const size_t length = strlen(path);
    return (length >= 4 && strcasecmp(path + length - 4, ".ply") == 0) ||
           memcmp(head, "ply\n", 4) == 0 || memcmp(head, "ply\r", 4) == 0;
}

bool mesh_file_read(const char *path, shape *out, char *error, size_t size) {
    char head[4] = {0};
    memset(out, 0, sizeof *out);
    FILE *file = fopen(path, "rb");
    const bool read = file && (fread(head, 1, sizeof head, file) > 0 || !ferror(file));
    const int cause = errno;
    if (file) fclose(file);
    if (!read) {
        const char *more = shape_text(path) ? "; for the built-in scene write --scene " : "";
        snprintf(error, size, "%s: %s%s%s", path, strerror(cause), more, *more ? path : "");
        return false;
    }
    if (is_ply(path, head)) return ply_read(path, out, error, size);
    if (read_by_assimp(path, out, error, size)) return true;
    shape_free(out);
    return false;
}
