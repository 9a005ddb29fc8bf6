#include "worker/pipeline/left_images.hpp"

#include <opencv2/imgproc.hpp>
#include <utility>

namespace divemesh::pipeline {

LeftImages::LeftImages(ReadColor read, std::size_t capacity)
    : read_(std::move(read)), capacity_(capacity) {}

cv::Mat LeftImages::grey(int frame_index) {
    std::promise<cv::Mat> promise;
    std::shared_future<cv::Mat> image;
    bool is_ours = false;  // to be read here, while others wait for it
    {
        const std::lock_guard lock(mutex_);
        const auto [place, is_new] = images_.try_emplace(frame_index);
        if (is_new) {
            place->second = promise.get_future().share();
            order_.push_back(frame_index);
        }
        is_ours = is_new;
        image = place->second;
        if (order_.size() > capacity_) {
            images_.erase(order_.front());
            order_.pop_front();
        }
    }
    if (is_ours) {
        try {
            cv::Mat grey;
            cv::cvtColor(read_(frame_index), grey, cv::COLOR_BGR2GRAY);
            promise.set_value(grey);
        } catch (...) {
            promise.set_exception(std::current_exception());
        }
    }
    return image.get();
}

}  // namespace divemesh::pipeline
