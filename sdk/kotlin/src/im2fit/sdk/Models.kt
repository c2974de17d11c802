// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

import java.io.File

/** Where one data file is. */
sealed class ModelFile {
    /** A file of the file system; copied when the session is opened, mapped when it has more than 64 MiB. */
    data class Path(val file: File) : ModelFile()

    /** Its whole content; copied when the session is opened. */
    class Bytes(val bytes: ByteArray) : ModelFile()

    /**
     * A part of an open file: what `AssetFileDescriptor` gives of an asset that is stored without compression
     * (`noCompress "i2b", "i2t", "i2f"`). Copied when the session is opened; the caller closes [fd] afterwards.
     *
     * @property fd `parcelFileDescriptor.fd`
     * @property offset `startOffset`, bytes
     * @property length `length`, bytes
     */
    data class Descriptor(val fd: Int, val offset: Long, val length: Long) : ModelFile()
}

/**
 * The files that measuring needs, out of one model pack (docs/models.md).
 *
 * @property body without it there is no mesh, tape or avatar, and no shape is fitted
 */
class Models(val tracker: ModelFile, val index: ModelFile, val body: ModelFile? = null) {
    companion object {
        /** tracker.i2t, index.i2f and body.i2b of a directory, as `im2fit models install` puts them there. */
        @JvmStatic
        fun of(directory: File): Models {
            val files = listOf("tracker.i2t", "index.i2f", "body.i2b").map { File(directory, it) }
            val lacking = files.filterNot { it.isFile }
            require(lacking.isEmpty()) { "no ${lacking.joinToString { it.name }} in $directory: im2fit models install PACK.i2p" }
            val (tracker, index, body) = files.map { ModelFile.Path(it) }
            return Models(tracker, index, body)
        }
    }
}

/**
 * What the models of a session are and can answer: for a support page, or to refuse a pack that is not enough.
 *
 * @property madeBy by which program the index was made, and from what
 * @property people whom the index was made of
 * @property captures of these people, in the index
 * @property trackerKey names the tracker; an index made with another is refused when opened
 * @property hasBody meshes, tape, avatars and garments are there
 * @property answersShape a shape is fitted to the depth as well; false: answers are less good
 * @property answersTurned the index knows people from behind
 * @property answersClothed it knows people in clothes
 * @property siteCorrected answers are corrected for the site
 */
data class ModelInfo(
    val madeBy: String, val people: Long, val captures: Long, val trackerKey: Long, val hasBody: Boolean,
    val answersShape: Boolean, val answersTurned: Boolean, val answersClothed: Boolean, val siteCorrected: Boolean
)
