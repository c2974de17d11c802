// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

import java.io.File

/** The location of one model file. */
sealed class ModelFile {
    /** A file of the file system. Opening a session copies it, or maps it when it is larger than 64 MiB. */
    data class Path(val file: File) : ModelFile()

    /** The content of the file. Opening a session copies it. */
    class Bytes(val bytes: ByteArray) : ModelFile()

    /**
     * A part of an open file, as `AssetFileDescriptor` has it for an asset that is stored without compression
     * (`androidResources { noCompress += "i2p" }`). Opening a session copies it. The caller closes
     * [fd] afterwards.
     *
     * @property fd `parcelFileDescriptor.fd`
     * @property offset `startOffset`, bytes
     * @property length `length`, bytes
     */
    data class Descriptor(val fd: Int, val offset: Long, val length: Long) : ModelFile()
}

/**
 * The model files, all of one model pack (docs/models.md).
 *
 * @property body null: there is no mesh, tape, avatar or garment fit, and no shape is fitted
 */
class Models(val tracker: ModelFile, val index: ModelFile, val body: ModelFile? = null) {
    companion object {
        /** All models of one pack (.i2p). If the library was built without zstd, use a pack made with `im2fit-lab pack --stored`. */
        @JvmStatic
        fun ofPack(pack: ModelFile): Models = Models(pack, pack, pack)

        /** A pack (.i2p); or tracker.i2t, index.i2f and body.i2b of a directory, as `im2fit models install` puts them there. */
        @JvmStatic
        fun of(directory: File): Models {
            if (directory.isFile) return ofPack(ModelFile.Path(directory))
            val files = listOf("tracker.i2t", "index.i2f", "body.i2b").map { File(directory, it) }
            val lacking = files.filterNot { it.isFile }
            require(lacking.isEmpty()) { "no ${lacking.joinToString { it.name }} in $directory: im2fit models install PACK.i2p" }
            val (tracker, index, body) = files.map { ModelFile.Path(it) }
            return Models(tracker, index, body)
        }
    }
}

/**
 * Describes the models of a session, for a support page or to check that the models have the required features.
 *
 * @property madeBy the program that made the index, and its source data
 * @property people number of people in the index
 * @property captures number of captures of these people in the index
 * @property trackerKey identifies the tracker. Opening refuses an index made with another
 * @property hasBody meshes, tape, avatars and garments are available
 * @property answersShape a shape is fitted to the depth. False: measurements are less accurate
 * @property answersTurned the index covers people from behind
 * @property answersClothed the index covers people in clothes
 * @property siteCorrected measurements are corrected for the site
 */
data class ModelInfo(
    val madeBy: String, val people: Long, val captures: Long, val trackerKey: Long, val hasBody: Boolean,
    val answersShape: Boolean, val answersTurned: Boolean, val answersClothed: Boolean, val siteCorrected: Boolean
)
