// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

import java.nio.ByteBuffer
import java.nio.ByteOrder

/** How samples are stored. Order of IM2FIT_FORMAT_... */
enum class DepthFormat(internal val sampleBytes: Int) {
    /** 16-bit integers in units of [DepthFrame.unitMm]; 0: no data. */
    U16(2),
    /** Android's `ImageFormat.DEPTH16`: 13 low bits are millimetres, 3 high bits confidence. */
    DEPTH16(2),
    /** 32-bit floats, metres; NaN, infinite, zero and negative: no data. */
    F32(4)
}

/** A direction of any length in the axes of the frame as delivered: x right, y down, z forward. */
data class Direction(val x: Float, val y: Float, val z: Float) {
    companion object {
        /**
         * Down, from Android's gravity sensor (`Sensor.TYPE_GRAVITY`), for a camera on the back of the device.
         *
         * @param values of the `SensorEvent`, which point up: x to the right of the screen, y to its top, z out of it
         * @param rotateDeg [CameraModel.rotateDeg]: `SENSOR_ORIENTATION` of the camera
         */
        @JvmStatic
        fun ofAndroidGravity(values: FloatArray, rotateDeg: Int): Direction {
            // In the picture turned upright in the screen's natural orientation.
            val (x, y, z) = listOf(-values[0], values[1], values[2])
            return when (rotateDeg) {
                90 -> Direction(y, -x, z)
                180 -> Direction(-x, -y, z)
                270 -> Direction(-y, x, z)
                else -> Direction(x, y, z)
            }
        }
    }
}

/**
 * The pose of a hand-held camera, as the platform tracks it (ARCore): the unit quaternion from the axes of the frame as
 * delivered (x right, y down, z forward) to static axes, and the position of the camera in the static axes.
 *
 * @property xMm millimetres. 0 0 0: only the rotation is known, and the camera is assumed to rotate about itself
 */
data class CameraPose(
    val x: Float, val y: Float, val z: Float, val w: Float, val xMm: Float = 0f, val yMm: Float = 0f, val zMm: Float = 0f
) {
    companion object {
        /**
         * @param rotation of `Frame.getCamera().getPose().getRotationQuaternion()`: x, y, z, w, of axes with y up and z
         *   backwards. That of the physical camera, whose axes are the delivered picture's, not `getDisplayOrientedPose()`
         * @param translation of `getTranslation()`, metres
         */
        @JvmStatic
        fun ofArCore(rotation: FloatArray, translation: FloatArray): CameraPose {
            val (x, y, z, w) = rotation
            return CameraPose(w, z, -y, -x, 1000 * translation[0], 1000 * translation[1], 1000 * translation[2])
        }
    }
}

/**
 * One depth frame in the format of the camera. It is copied only by [FitSession.push].
 *
 * @property pixels a direct buffer in the machine's byte order, read from its position. Rows from the top
 * @property rowBytes from row to row; 0: no padding (`Image.Plane.getRowStride()`)
 * @property timeNs monotonic (`Image.getTimestamp()`); 0: none
 * @property sequence the camera's frame number, to detect gaps; 0: none
 * @property confidence U16, F32: a direct buffer with one byte per sample. Below [confidenceMin]: no data
 * @property confidenceMin 0: use all samples. DEPTH16: sevenths of full confidence, 0..7. Others: of [confidence], 0..255
 * @property camera the intrinsics of this frame, when focus or calibration changes; null: the session's
 * @property unitMm millimetres of a unit, U16 only
 * @property down the direction of gravity; null: unknown, and the latest known direction is used until [FitSession.reset]. It
 *   defines the vertical where no floor is visible
 * @property pose the pose of a hand-held camera; null: unknown, and the frame is used without resampling
 */
class DepthFrame(
    val pixels: ByteBuffer, val format: DepthFormat, val rowBytes: Int = 0, val timeNs: Long = 0, val sequence: Long = 0,
    val confidence: ByteBuffer? = null, val confidenceRowBytes: Int = 0, val confidenceMin: Int = 0,
    val camera: CameraModel? = null, val unitMm: Float = 1f, val down: Direction? = null,
    val pose: CameraPose? = null
) {
    init {
        require(pixels.isDirect) { "pixels must be a direct buffer (ByteBuffer.allocateDirect, or a plane of an Image)" }
        require(confidence == null || confidence.isDirect) { "confidence must be a direct buffer" }
    }

    internal fun checkSize(width: Int, height: Int) {
        val row = if (rowBytes == 0) width * format.sampleBytes else rowBytes
        val needed = row.toLong() * (height - 1) + width.toLong() * format.sampleBytes
        require(rowBytes >= 0 && pixels.remaining() >= needed) {
            "pixels has ${pixels.remaining()} bytes, $width x $height samples of $format in rows of $row need $needed"
        }
        if (confidence == null) return
        val confidenceRow = if (confidenceRowBytes == 0) width else confidenceRowBytes
        val plane = confidenceRow.toLong() * (height - 1) + width
        require(confidenceRowBytes >= 0 && confidence.remaining() >= plane) {
            "confidence has ${confidence.remaining()} bytes, $width x $height in rows of $confidenceRow need $plane"
        }
    }

    companion object {
        /** A frame of millimetres from an array, by copying it. For the frames of a camera reuse one direct buffer instead. */
        @JvmStatic
        @JvmOverloads
        fun ofMillimetres(depth: ShortArray, timeNs: Long = 0, sequence: Long = 0): DepthFrame {
            val buffer = ByteBuffer.allocateDirect(2 * depth.size).order(ByteOrder.nativeOrder())
            buffer.asShortBuffer().put(depth)
            return DepthFrame(buffer, DepthFormat.U16, timeNs = timeNs, sequence = sequence)
        }

        /** A frame of metres from an array, by copying it. */
        @JvmStatic
        @JvmOverloads
        fun ofMetres(depth: FloatArray, timeNs: Long = 0, sequence: Long = 0): DepthFrame {
            val buffer = ByteBuffer.allocateDirect(4 * depth.size).order(ByteOrder.nativeOrder())
            buffer.asFloatBuffer().put(depth)
            return DepthFrame(buffer, DepthFormat.F32, timeNs = timeNs, sequence = sequence)
        }
    }
}
